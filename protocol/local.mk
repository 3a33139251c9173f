# libglint: what the daemon and its clients share.

noinst_LIBRARIES += libglint.a
libglint_a_SOURCES = \
	protocol/arena.h \
	protocol/cryptomatte.h \
	protocol/dials.h \
	protocol/exr.h \
	protocol/frame.h \
	protocol/job.h \
	protocol/scene.h \
	protocol/status.h
