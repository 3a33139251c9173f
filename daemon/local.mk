# libglintdaemon: all of the daemon but its main function, so that tests can link it.

noinst_LIBRARIES += libglintdaemon.a
libglintdaemon_a_SOURCES = \
	daemon/base/clock.c \
	daemon/base/clock.h \
	daemon/base/config.c \
	daemon/base/config.h \
	daemon/base/file.c \
	daemon/base/file.h \
	daemon/base/folders.c \
	daemon/base/folders.h \
	daemon/base/journal.c \
	daemon/base/journal.h \
	daemon/base/journal_schema.c \
	daemon/base/journal_schema.h \
	daemon/base/keeper.c \
	daemon/base/keeper.h \
	daemon/base/listen.c \
	daemon/base/listen.h \
	daemon/base/log.c \
	daemon/base/log.h \
	daemon/base/memory.c \
	daemon/base/memory.h \
	daemon/base/metrics.c \
	daemon/base/metrics.h \
	daemon/base/notify.c \
	daemon/base/notify.h \
	daemon/base/process.c \
	daemon/base/process.h \
	daemon/base/queue.c \
	daemon/base/queue.h \
	daemon/base/sha256.c \
	daemon/base/sha256.h \
	daemon/base/storage.c \
	daemon/base/storage.h \
	daemon/base/thread.c \
	daemon/base/thread.h \
	daemon/base/tokens.c \
	daemon/base/tokens.h \
	daemon/base/vault.c \
	daemon/base/vault.h \
	daemon/device/ahead.c \
	daemon/device/ahead.h \
	daemon/device/bitcode.c \
	daemon/device/bitcode.h \
	daemon/device/buffer.c \
	daemon/device/compiler.c \
	daemon/device/compiler.h \
	daemon/device/device.c \
	daemon/device/device.h \
	daemon/device/foresee.c \
	daemon/device/internal.h \
	daemon/device/launch.c \
	daemon/device/listing.c \
	daemon/device/listing.h \
	daemon/device/platform.c \
	daemon/device/program.c \
	daemon/device/program.h \
	daemon/device/source.c \
	daemon/device/sources.h \
	daemon/http/accept.c \
	daemon/http/accept.h \
	daemon/http/accuracy.c \
	daemon/http/answer.c \
	daemon/http/answer.h \
	daemon/http/assets.c \
	daemon/http/auth.c \
	daemon/http/auth.h \
	daemon/http/blob.c \
	daemon/http/blob.h \
	daemon/http/board.c \
	daemon/http/board.h \
	daemon/http/body.c \
	daemon/http/contract.h \
	daemon/http/dispatch.c \
	daemon/http/dispatch.h \
	daemon/http/events.c \
	daemon/http/events.h \
	daemon/http/film.c \
	daemon/http/frame.c \
	daemon/http/frames.c \
	daemon/http/frames.h \
	daemon/http/heartbeat.c \
	daemon/http/http.c \
	daemon/http/http.h \
	daemon/http/jobs.c \
	daemon/http/limits.c \
	daemon/http/mattes.c \
	daemon/http/media.c \
	daemon/http/media.h \
	daemon/http/offload.c \
	daemon/http/offload.h \
	daemon/http/picture.c \
	daemon/http/picture.h \
	daemon/http/pixels.c \
	daemon/http/pixels.h \
	daemon/http/plan.c \
	daemon/http/range.c \
	daemon/http/range.h \
	daemon/http/record.c \
	daemon/http/record.h \
	daemon/http/request.c \
	daemon/http/request.h \
	daemon/http/resources.h \
	daemon/http/routes.c \
	daemon/http/routes.h \
	daemon/http/scenes.c \
	daemon/http/server.h \
	daemon/http/service.c \
	daemon/http/stats.c \
	daemon/http/stream.c \
	daemon/http/stream.h \
	daemon/http/tiles.c \
	daemon/http/topic.c \
	daemon/http/topic.h \
	daemon/http/tls.c \
	daemon/http/tls.h \
	daemon/http/trace.c \
	daemon/http/trace.h \
	daemon/http/viewer.c \
	daemon/http/viewer.h \
	daemon/http/watch.c \
	daemon/http/watch.h \
	daemon/jobs/admit.c \
	daemon/jobs/admit.h \
	daemon/jobs/checkpoint.c \
	daemon/jobs/checkpoint.h \
	daemon/jobs/checkpoint_file.c \
	daemon/jobs/checkpoint_file.h \
	daemon/jobs/checkpoint_parts.c \
	daemon/jobs/checkpoint_parts.h \
	daemon/jobs/checkpoint_read.c \
	daemon/jobs/checkpoint_sweep.c \
	daemon/jobs/commands.c \
	daemon/jobs/crew.c \
	daemon/jobs/crew.h \
	daemon/jobs/describe.c \
	daemon/jobs/describe.h \
	daemon/jobs/jobs.c \
	daemon/jobs/jobs.h \
	daemon/jobs/invariants.c \
	daemon/jobs/invariants.h \
	daemon/jobs/journal.c \
	daemon/jobs/journal.h \
	daemon/jobs/list.c \
	daemon/jobs/look.c \
	daemon/jobs/look.h \
	daemon/jobs/outlook.c \
	daemon/jobs/outlook.h \
	daemon/jobs/need.c \
	daemon/jobs/need.h \
	daemon/jobs/patch.c \
	daemon/jobs/patch.h \
	daemon/jobs/restart.c \
	daemon/jobs/restart.h \
	daemon/jobs/scheduler.c \
	daemon/jobs/scheduler_orders.c \
	daemon/jobs/scheduler.h \
	daemon/jobs/scheduler_parts.h \
	daemon/jobs/state.c \
	daemon/jobs/state.h \
	daemon/jobs/stats.c \
	daemon/jobs/table.c \
	daemon/jobs/table.h \
	daemon/jobs/turn.c \
	daemon/jobs/turn.h \
	daemon/jobs/choose.c \
	daemon/jobs/choose.h \
	daemon/jobs/price.c \
	daemon/jobs/price.h \
	daemon/jobs/use.c \
	daemon/jobs/use.h \
	daemon/jobs/warn.c \
	daemon/jobs/warn.h \
	daemon/render/adaptive.c \
	daemon/render/adaptive.h \
	daemon/render/archive.c \
	daemon/render/archive.h \
	daemon/render/camera.c \
	daemon/render/capture.c \
	daemon/render/capture.h \
	daemon/render/common.c \
	daemon/render/common.h \
	daemon/render/compact.c \
	daemon/render/compact.h \
	daemon/render/carried.c \
	daemon/render/effects.c \
	daemon/render/effects.h \
	daemon/render/estimate.c \
	daemon/render/estimate.h \
	daemon/render/film.c \
	daemon/render/film.h \
	daemon/render/film_capture.c \
	daemon/render/film_spread.c \
	daemon/render/film_parts.h \
	daemon/render/forecast.c \
	daemon/render/forecast.h \
	daemon/render/inside.c \
	daemon/render/internal.h \
	daemon/render/pass.c \
	daemon/render/measure.c \
	daemon/render/order.c \
	daemon/render/order.h \
	daemon/render/plan.c \
	daemon/render/plan.h \
	daemon/render/render.c \
	daemon/render/render.h \
	daemon/render/resolve.c \
	daemon/render/restore.c \
	daemon/render/size.c \
	daemon/render/sound.c \
	daemon/render/view.c \
	daemon/render/wave.c \
	daemon/render/hold.c \
	daemon/render/hold.h \
	daemon/render/wave.h \
	daemon/render/wave_parts.h \
	daemon/scene/alias.c \
	daemon/scene/alias.h \
	daemon/scene/asset_set.c \
	daemon/scene/assets.c \
	daemon/scene/assets.h \
	daemon/scene/centre.c \
	daemon/scene/data_uri.c \
	daemon/scene/data_uri.h \
	daemon/scene/energy.c \
	daemon/scene/energy.h \
	daemon/scene/energy_rows.c \
	daemon/scene/energy_rows.h \
	daemon/scene/curvature.c \
	daemon/scene/curvature.h \
	daemon/scene/edit.c \
	daemon/scene/edit.h \
	daemon/scene/environment.c \
	daemon/scene/exr_read.cc \
	daemon/scene/exr_read.h \
	daemon/scene/facts.c \
	daemon/scene/facts.h \
	daemon/scene/files.c \
	daemon/scene/files.h \
	daemon/scene/form.c \
	daemon/scene/form.h \
	daemon/scene/geometry.c \
	daemon/scene/geometry.h \
	daemon/scene/gltf.c \
	daemon/scene/gltf.h \
	daemon/scene/gltf_accessor.c \
	daemon/scene/gltf_animations.c \
	daemon/scene/gltf_assimp.c \
	daemon/scene/gltf_attributes.c \
	daemon/scene/gltf_buffers.c \
	daemon/scene/gltf_cameras.c \
	daemon/scene/gltf_container.c \
	daemon/scene/gltf_file.c \
	daemon/scene/gltf_file.h \
	daemon/scene/gltf_frames.c \
	daemon/scene/gltf_geometry.c \
	daemon/scene/gltf_instancing.c \
	daemon/scene/gltf_lights.c \
	daemon/scene/gltf_materials.c \
	daemon/scene/gltf_matrix.c \
	daemon/scene/gltf_meshes.c \
	daemon/scene/gltf_names.c \
	daemon/scene/gltf_nodes.c \
	daemon/scene/gltf_notes.c \
	daemon/scene/gltf_primitives.c \
	daemon/scene/gltf_skins.c \
	daemon/scene/gltf_surfaces.c \
	daemon/scene/gltf_textures.c \
	daemon/scene/image_decode.c \
	daemon/scene/image_decode.h \
	daemon/scene/image_decode_exr.c \
	daemon/scene/image_decode_hdr.c \
	daemon/scene/image_decode_jpeg.c \
	daemon/scene/image_decode_png.c \
	daemon/scene/import.c \
	daemon/scene/import.h \
	daemon/scene/import_answer.c \
	daemon/scene/import_answer.h \
	daemon/scene/import_child.c \
	daemon/scene/import_child.h \
	daemon/scene/import_helper.c \
	daemon/scene/import_helper.h \
	daemon/scene/import_jail.c \
	daemon/scene/import_jail.h \
	daemon/scene/import_multipart.c \
	daemon/scene/import_native.c \
	daemon/scene/instances.c \
	daemon/scene/internal.h \
	daemon/scene/keep.c \
	daemon/scene/keep_ahead.c \
	daemon/scene/keep_bring.c \
	daemon/scene/keep.h \
	daemon/scene/keep_collect.c \
	daemon/scene/keep_parts.h \
	daemon/scene/kept.c \
	daemon/scene/light_clusters.c \
	daemon/scene/light_clusters.h \
	daemon/scene/light_grid.c \
	daemon/scene/light_grid.h \
	daemon/scene/lights.c \
	daemon/scene/materials.c \
	daemon/scene/matrix.c \
	daemon/scene/matrix.h \
	daemon/scene/matte_names.c \
	daemon/scene/mattes.c \
	daemon/scene/model.c \
	daemon/scene/model.h \
	daemon/scene/mtl.c \
	daemon/scene/mtl.h \
	daemon/scene/mtl_images.c \
	daemon/scene/mtl_material.c \
	daemon/scene/obj.c \
	daemon/scene/obj_file.h \
	daemon/scene/obj_meshes.c \
	daemon/scene/opacity.c \
	daemon/scene/place.c \
	daemon/scene/ply.c \
	daemon/scene/ply_header.c \
	daemon/scene/ply_header.h \
	daemon/scene/polygon.c \
	daemon/scene/polygon.h \
	daemon/scene/pose.c \
	daemon/scene/pose.h \
	daemon/scene/pose_channel.c \
	daemon/scene/pose_deform.c \
	daemon/scene/pose_instances.c \
	daemon/scene/pose_keys.c \
	daemon/scene/pose_matrix.c \
	daemon/scene/pose_nodes.c \
	daemon/scene/pose_placements.c \
	daemon/scene/pose_shape.c \
	daemon/scene/pose_track.c \
	daemon/scene/pose_wanted.c \
	daemon/scene/pose_work.h \
	daemon/scene/posed.c \
	daemon/scene/posed.h \
	daemon/scene/records.c \
	daemon/scene/records.h \
	daemon/scene/resident.c \
	daemon/scene/resident.h \
	daemon/scene/revision.c \
	daemon/scene/revision.h \
	daemon/scene/revision_describe.c \
	daemon/scene/revision_parts.h \
	daemon/scene/rows.c \
	daemon/scene/shape.c \
	daemon/scene/shape.h \
	daemon/scene/share.c \
	daemon/scene/share_lights.c \
	daemon/scene/stl.c \
	daemon/scene/store.c \
	daemon/scene/store.h \
	daemon/scene/store_parts.h \
	daemon/scene/store_recall.c \
	daemon/scene/tangents.c \
	daemon/scene/textures.c \
	daemon/scene/ties.c \
	daemon/scene/words.c \
	daemon/scene/words.h
nodist_libglintdaemon_a_SOURCES = clients/web/embedded.c kernels/embedded.c protocol/contract.c \
	daemon/jobs/fronts.c daemon/scene/energy_tables.c

# What the scenes of most people ask of gk_energy.h, integrated once, when the daemon is built.
noinst_PROGRAMS = energy-usual
energy_usual_SOURCES = daemon/scene/energy_rows.c daemon/scene/energy_usual.c
energy_usual_LDADD = -lm

daemon/scene/energy_tables.c: energy-usual$(EXEEXT)
	$(AM_V_GEN)$(MKDIR_P) daemon/scene && ./energy-usual$(EXEEXT) >$@.t && mv $@.t $@

CLEANFILES += daemon/scene/energy_tables.c

# What accuracy costs in scenes of each class, as `glint accuracy` measured it: docs/accuracy.
class_fronts = \
	daemon/jobs/fronts/glass.json \
	daemon/jobs/fronts/lights.json \
	daemon/jobs/fronts/plain.json \
	daemon/jobs/fronts/textured.json
EXTRA_DIST += $(class_fronts)

daemon/jobs/fronts.c: $(class_fronts) build-aux/embed.awk
	$(AM_V_GEN)$(MKDIR_P) daemon/jobs
	$(AM_V_at)( echo '#include "jobs/price.h"'; \
	  for f in $(class_fronts); do printf 'file %s\n' $${f##*/}; \
	    od -An -v -tu1 $(top_srcdir)/$$f || exit 1; done | \
	  $(AWK) -f $(top_srcdir)/build-aux/embed.awk | \
	  $(SED) 's/glint_sources/glint_class_fronts/' ) >$@.t && mv $@.t $@

CLEANFILES += daemon/jobs/fronts.c

bin_PROGRAMS += glintd
glintd_SOURCES = \
	daemon/house.h \
	daemon/main.c \
	daemon/mirror.c \
	daemon/mirror.h \
	daemon/options.c \
	daemon/options.h \
	daemon/serve.c \
	daemon/serve.h \
	daemon/settings.c \
	daemon/settings.h \
	daemon/ticker.c \
	daemon/ticker.h \
	daemon/warm.c \
	daemon/warm.h
glintd_LDADD = $(DAEMON_LIBS)

# Started by glintd: compiles kernels beside it.
AM_CPPFLAGS += -DGLINT_LIBEXEC=\"$(pkglibexecdir)\"
pkglibexec_PROGRAMS = glint-kernels
glint_kernels_SOURCES = daemon/device/kernels.c
glint_kernels_LDADD = libglintdaemon.a libglint.a $(OPENCL_LIBS) $(CRYPTO_LIBS) $(CJSON_LIBS) \
	$(SYSTEMD_LIBS) -lm -ldl
EXTRA_glintd_DEPENDENCIES = glint-kernels$(EXEEXT)
