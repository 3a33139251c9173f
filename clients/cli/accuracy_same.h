// accuracy_same.h - whether a folder of a report is of the programme that is to go on in it.
//
// Thread-safety: none needed.
#ifndef GLINT_CLI_ACCURACY_SAME_H
#define GLINT_CLI_ACCURACY_SAME_H

#include "protocol/status.h"

#include <cjson/cJSON.h>

// Compares the members of `programme` with those in work/programme.json, which is written where it
// is not there yet. Seeds, samples and dials are not among them: a run may want more of these.
//   GLINT_E_CONFLICT  it is of another one; *err names what differs
glint_status glint_accuracy_same(const char *folder, const cJSON *programme,
                                 struct glint_error *err);

#endif
