// contract.h - protocol/openapi.yaml, embedded by the build.
#ifndef GLINT_HTTP_CONTRACT_H
#define GLINT_HTTP_CONTRACT_H

#include "device/sources.h"

extern const struct glint_source glint_contract[]; // one row

#endif
