# libglint: what the daemon and its clients share.

noinst_LIBRARIES += libglint.a
libglint_a_SOURCES = \
	protocol/arena.c \
	protocol/arena.h \
	protocol/cryptomatte.c \
	protocol/cryptomatte.h \
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
	protocol/json_read.c \
	protocol/multipart.c \
	protocol/multipart.h \
	protocol/png.c \
	protocol/png.h \
	protocol/problem.c \
	protocol/problem.h \
	protocol/scene.c \
	protocol/scene.h \
	protocol/scene_asset.c \
	protocol/scene_complete.c \
	protocol/scene_fields.c \
	protocol/scene_ids.c \
	protocol/scene_items.c \
	protocol/scene_mesh.c \
	protocol/scene_mesh_check.c \
	protocol/scene_parse.c \
	protocol/scene_parts.h \
	protocol/scene_primitives.c \
	protocol/scene_transform.c \
	protocol/scene_write.c \
	protocol/status.c \
	protocol/status.h \
	protocol/text.c \
	protocol/text.h \
	protocol/utf8.c \
	protocol/utf8.h
