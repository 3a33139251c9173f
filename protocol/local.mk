# libglint: what the daemon and its clients share.

noinst_LIBRARIES += libglint.a
libglint_a_SOURCES = \
	protocol/accuracy_front.c \
	protocol/accuracy_front.h \
	protocol/accuracy_knobs.c \
	protocol/accuracy_knobs.h \
	protocol/arena.c \
	protocol/arena.h \
	protocol/counts.c \
	protocol/counts.h \
	protocol/cryptomatte.c \
	protocol/cryptomatte.h \
	protocol/bias.c \
	protocol/bias.h \
	protocol/dials.c \
	protocol/dials.h \
	protocol/exr.h \
	protocol/exr_read.c \
	protocol/exr_stream.c \
	protocol/exr_stream.h \
	protocol/exr_write.c \
	protocol/exr_zip.c \
	protocol/exr_zip.h \
	protocol/fields.c \
	protocol/fields.h \
	protocol/film.c \
	protocol/film.h \
	protocol/film_add.c \
	protocol/film_add.h \
	protocol/film_file.h \
	protocol/film_frame.c \
	protocol/film_header.c \
	protocol/film_header.h \
	protocol/film_levels.c \
	protocol/film_levels.h \
	protocol/film_matte.c \
	protocol/film_merge.c \
	protocol/film_merge.h \
	protocol/film_pack.c \
	protocol/film_pack.h \
	protocol/film_parts.h \
	protocol/film_pick.c \
	protocol/film_rank.c \
	protocol/film_read.c \
	protocol/film_same.c \
	protocol/film_words.h \
	protocol/film_write.c \
	protocol/frame.c \
	protocol/frame.h \
	protocol/half.h \
	protocol/job.c \
	protocol/job.h \
	protocol/job_parse.c \
	protocol/job_parts.h \
	protocol/job_write.c \
	protocol/json.c \
	protocol/json.h \
	protocol/json_check.c \
	protocol/json_lists.c \
	protocol/json_lists.h \
	protocol/json_read.c \
	protocol/matte_types.c \
	protocol/matte_types.h \
	protocol/multipart.c \
	protocol/multipart.h \
	protocol/nearest.c \
	protocol/nearest.h \
	protocol/png.c \
	protocol/png.h \
	protocol/problem.c \
	protocol/problem.h \
	protocol/scene.c \
	protocol/scene.h \
	protocol/scene_animation.c \
	protocol/scene_asset.c \
	protocol/scene_box.c \
	protocol/scene_complete.c \
	protocol/scene_fields.c \
	protocol/scene_hashes.c \
	protocol/scene_ids.c \
	protocol/scene_instance.c \
	protocol/scene_items.c \
	protocol/scene_mesh.c \
	protocol/scene_mesh_check.c \
	protocol/scene_mesh_inline.c \
	protocol/scene_mesh_layout.c \
	protocol/scene_nodes.c \
	protocol/scene_parse.c \
	protocol/scene_parts.h \
	protocol/scene_primitives.c \
	protocol/scene_reach.c \
	protocol/scene_skin.c \
	protocol/scene_transform.c \
	protocol/scene_trust.c \
	protocol/scene_write.c \
	protocol/status.c \
	protocol/status.h \
	protocol/text.c \
	protocol/text.h \
	protocol/utf8.c \
	protocol/utf8.h

# The contract is served whole: what openapi.yaml takes from schema/ is put in its place.
contract_sources = \
	protocol/openapi.yaml \
	protocol/schema/job.json \
	protocol/schema/scene.json
EXTRA_DIST += build-aux/bundle.awk $(contract_sources) \
	protocol/examples/job.json protocol/examples/scene.json \
	protocol/examples/walkthrough.sh

protocol/contract.c: $(contract_sources) build-aux/bundle.awk build-aux/embed.awk
	$(AM_V_GEN)$(MKDIR_P) protocol
	$(AM_V_at)$(AWK) -f $(top_srcdir)/build-aux/bundle.awk \
	  $(top_srcdir)/protocol/openapi.yaml >$@.yaml
	$(AM_V_at)( echo '#include "http/contract.h"'; \
	  ( echo 'file openapi.yaml'; od -An -v -tu1 $@.yaml ) | \
	  $(AWK) -f $(top_srcdir)/build-aux/embed.awk | \
	  $(SED) 's/glint_sources/glint_contract/' ) >$@.t
	$(AM_V_at)rm -f $@.yaml && mv $@.t $@

CLEANFILES += protocol/contract.c
