# Kernels are checked by clang and embedded as bytes; nothing reads them from a disk at run time.
# kernel_headers are compiled by host and device alike, kernel_sources hold the entry points.

kernel_headers = \
	kernels/gk_bsdf.h \
	kernels/gk_camera.h \
	kernels/gk_coat.h \
	kernels/gk_coverage.h \
	kernels/gk_cut.h \
	kernels/gk_energy.h \
	kernels/gk_environment.h \
	kernels/gk_facet.h \
	kernels/gk_film.h \
	kernels/gk_filter.h \
	kernels/gk_frame.h \
	kernels/gk_fresnel.h \
	kernels/gk_ggx.h \
	kernels/gk_held.h \
	kernels/gk_hit.h \
	kernels/gk_light.h \
	kernels/gk_light_grid.h \
	kernels/gk_lobes.h \
	kernels/gk_math.h \
	kernels/gk_matte.h \
	kernels/gk_matte_shared.h \
	kernels/gk_matte_spill.h \
	kernels/gk_medium.h \
	kernels/gk_sampler.h \
	kernels/gk_pair.h \
	kernels/gk_passing.h \
	kernels/gk_radiance.h \
	kernels/gk_scatter.h \
	kernels/gk_scene.h \
	kernels/gk_solid.h \
	kernels/gk_surface.h \
	kernels/gk_texture.h \
	kernels/gk_transport.h \
	kernels/gk_types.h \
	kernels/gk_vec.h \
	kernels/gk_vertex.h \
	kernels/gk_wave.h

kernel_sources = \
	kernels/coverage.cl \
	kernels/film.cl \
	kernels/generate.cl \
	kernels/shade.cl \
	kernels/shadow.cl

# Every -D that the effects table can set: the kernels are checked with none and with all of them.
kernel_options = -DGK_AOVS -DGK_BLEND -DGK_CAMERA_MOTION -DGK_CLEARCOAT -DGK_COLLIMATION \
	-DGK_CULL -DGK_EMISSION -DGK_EMISSION_TEXTURES -DGK_ENVIRONMENT_CONSTANT -DGK_ENVIRONMENT_IMAGE -DGK_FILM_FP64 \
	-DGK_FILTER_BLACKMAN_HARRIS -DGK_FLOW -DGK_GLOSSY_MATTES -DGK_INSTANCES -DGK_LAYER_TEXTURES -DGK_LENS -DGK_LIGHTS \
	-DGK_LIGHTS_UNIFORM -DGK_LIGHT_GRID -DGK_LIGHT_GRID_MANY -DGK_LIGHT_TABLE -DGK_MEDIUM -DGK_MICROFACET -DGK_MOTION \
	-DGK_MULTISCATTER -DGK_NEAREST_TEXELS -DGK_NESTED -DGK_NORMAL_MAPS -DGK_ORTHOGRAPHIC \
	-DGK_OPAQUE_FULL -DGK_PATH_LIST -DGK_ROUGHNESS_TEXTURES -DGK_SHARED_TABLES -DGK_SOLIDS -DGK_SPECULAR -DGK_TEXTURES -DGK_TEXTURE_POOLS=4 -DGK_TEXTURE_TRANSFORMS \
	-DGK_THROUGH -DGK_TRANSMISSION -DGK_UV1 -DGK_VERTEX_COLOURS

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
