# Kernels are checked by clang and embedded as bytes; nothing reads them from a disk at run time.
# kernel_headers are compiled by host and device alike, kernel_sources hold the entry points.

kernel_headers = kernels/gk_filter.h kernels/gk_math.h kernels/gk_matte.h kernels/gk_sampler.h kernels/gk_types.h

kernel_sources =

# Every -D that the effects table can set: the kernels are checked with none and with all of them.
kernel_options =

kernels = $(kernel_headers) $(kernel_sources)
EXTRA_DIST += $(kernels)

kernel_check = $(CLANG) -x cl -cl-std=CL1.2 -fsyntax-only -Xclang -finclude-default-header -Wall \
	-Werror -DGK_DEVICE -I$(top_srcdir)

# Device and host compile each header alone (GK_LAYOUT compares sizes in both), the device each
# source file, and all of them together as they are built at run time.
kernels/checked: $(kernels)
	$(AM_V_GEN)$(MKDIR_P) kernels && for k in $(kernels); do \
	  printf '#include "%s"\n' $$k >$@.cl && \
	  $(kernel_check) $@.cl && $(kernel_check) $(kernel_options) $@.cl || exit 1; done
	$(AM_V_at)for k in $(kernel_headers); do printf '#include "%s"\n' $$k; done >$@.c && \
	  $(CC) $(DEFS) $(AM_CPPFLAGS) $(CPPFLAGS) $(AM_CFLAGS) $(CFLAGS) -fsyntax-only $@.c
	$(AM_V_at)for k in $(kernel_sources); do printf '#include "%s"\n' $$k; done >$@.cl && \
	  $(kernel_check) $@.cl && $(kernel_check) $(kernel_options) $@.cl
	$(AM_V_at)rm -f $@.c $@.cl && touch $@

kernels/embedded.c: kernels/checked build-aux/embed.awk
	$(AM_V_GEN)( echo '#include "device/sources.h"'; \
	  for k in $(kernels); do printf 'file %s\n' $$k; od -An -v -tu1 $(top_srcdir)/$$k || exit 1; \
	  done | $(AWK) -f $(top_srcdir)/build-aux/embed.awk ) >$@.t && mv $@.t $@

CLEANFILES += kernels/checked kernels/embedded.c
