# libglintdaemon: all of the daemon but its main function, so that tests can link it.

noinst_LIBRARIES += libglintdaemon.a
libglintdaemon_a_SOURCES = \
	daemon/base/clock.c \
	daemon/base/clock.h \
	daemon/base/log.c \
	daemon/base/log.h \
	daemon/base/metrics.c \
	daemon/base/metrics.h \
	daemon/base/queue.c \
	daemon/base/queue.h \
	daemon/base/thread.c \
	daemon/base/thread.h \
	daemon/device/buffer.c \
	daemon/device/device.c \
	daemon/device/device.h \
	daemon/device/internal.h \
	daemon/device/launch.c \
	daemon/device/platform.c \
	daemon/device/program.c \
	daemon/device/program.h \
	daemon/device/source.c \
	daemon/device/sources.h \
	daemon/jobs/jobs.h \
	daemon/render/camera.c \
	daemon/render/effects.c \
	daemon/render/effects.h \
	daemon/render/estimate.c \
	daemon/render/estimate.h \
	daemon/render/film.c \
	daemon/render/film.h \
	daemon/render/internal.h \
	daemon/render/mattes.c \
	daemon/render/plan.c \
	daemon/render/plan.h \
	daemon/render/ranking.c \
	daemon/render/ranking.h \
	daemon/render/render.c \
	daemon/render/render.h \
	daemon/render/resolve.c \
	daemon/render/wave.c \
	daemon/render/wave.h \
	daemon/scene/alias.c \
	daemon/scene/alias.h \
	daemon/scene/data_uri.c \
	daemon/scene/data_uri.h \
	daemon/scene/environment.c \
	daemon/scene/facts.c \
	daemon/scene/facts.h \
	daemon/scene/geometry.c \
	daemon/scene/geometry.h \
	daemon/scene/gltf.c \
	daemon/scene/gltf.h \
	daemon/scene/gltf_accessor.c \
	daemon/scene/gltf_assimp.c \
	daemon/scene/gltf_buffers.c \
	daemon/scene/gltf_cameras.c \
	daemon/scene/gltf_container.c \
	daemon/scene/gltf_file.c \
	daemon/scene/gltf_file.h \
	daemon/scene/gltf_geometry.c \
	daemon/scene/gltf_lights.c \
	daemon/scene/gltf_materials.c \
	daemon/scene/gltf_matrix.c \
	daemon/scene/gltf_meshes.c \
	daemon/scene/gltf_names.c \
	daemon/scene/gltf_nodes.c \
	daemon/scene/gltf_notes.c \
	daemon/scene/gltf_textures.c \
	daemon/scene/image_decode.c \
	daemon/scene/image_decode.h \
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
	daemon/scene/import_native.c \
	daemon/scene/internal.h \
	daemon/scene/lights.c \
	daemon/scene/materials.c \
	daemon/scene/place.c \
	daemon/scene/records.c \
	daemon/scene/resident.c \
	daemon/scene/resident.h \
	daemon/scene/rows.c \
	daemon/scene/sha256.c \
	daemon/scene/sha256.h \
	daemon/scene/store.h \
	daemon/scene/textures.c
nodist_libglintdaemon_a_SOURCES = kernels/embedded.c

if HAVE_GLINTD
bin_PROGRAMS += glintd
endif
glintd_SOURCES = daemon/main.c
glintd_LDADD = $(DAEMON_LIBS)
