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
	protocol/job.h \
	protocol/json.c \
	protocol/json.h \
	protocol/json_check.c \
	protocol/json_read.c \
	protocol/multipart.c \
	protocol/multipart.h \
	protocol/png.c \
	protocol/png.h \
	protocol/scene.h \
	protocol/status.c \
	protocol/status.h \
	protocol/text.c \
	protocol/text.h \
	protocol/utf8.c \
	protocol/utf8.h
