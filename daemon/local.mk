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
	daemon/render/render.h \
	daemon/scene/import.h \
	daemon/scene/resident.h \
	daemon/scene/store.h
nodist_libglintdaemon_a_SOURCES = kernels/embedded.c

if HAVE_GLINTD
bin_PROGRAMS += glintd
endif
glintd_SOURCES = daemon/main.c
glintd_LDADD = $(DAEMON_LIBS)
