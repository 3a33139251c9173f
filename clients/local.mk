# The clients; they link the protocol library and never the daemon's.

CLI_LIBS = libglintcli.a $(PROTOCOL_LIBS) $(CURL_LIBS)

noinst_LIBRARIES += libglintcli.a
libglintcli_a_SOURCES = \
	clients/cli/accuracy_ask.c clients/cli/accuracy_ask.h \
	clients/cli/accuracy_csv.c clients/cli/accuracy_csv.h \
	clients/cli/accuracy_files.c clients/cli/accuracy_files.h \
	clients/cli/accuracy_image.c clients/cli/accuracy_image.h \
	clients/cli/accuracy_mean.c clients/cli/accuracy_mean.h \
	clients/cli/accuracy_metric.c clients/cli/accuracy_metric.h \
	clients/cli/accuracy_pages.c \
	clients/cli/accuracy_pictures.c \
	clients/cli/accuracy_plan.c clients/cli/accuracy_plan.h \
	clients/cli/accuracy_plot.c clients/cli/accuracy_plot.h \
	clients/cli/accuracy_render.c clients/cli/accuracy_render.h \
	clients/cli/accuracy_report.h \
	clients/cli/accuracy_run.c clients/cli/accuracy_run.h \
	clients/cli/accuracy_same.c clients/cli/accuracy_same.h \
	clients/cli/accuracy_stat.c clients/cli/accuracy_stat.h \
	clients/cli/accuracy_sum.c \
	clients/cli/cmd_accuracy.c \
	clients/cli/adjust.c clients/cli/adjust.h \
	clients/cli/bundle.c clients/cli/bundle.h \
	clients/cli/client.c clients/cli/client.h \
	clients/cli/cmd_get.c \
	clients/cli/cmd_jobs.c \
	clients/cli/cmd_mattes.c \
	clients/cli/cmd_merge.c \
	clients/cli/cmd_pick.c \
	clients/cli/cmd_plan.c \
	clients/cli/cmd_recolor.c \
	clients/cli/through.c clients/cli/through.h \
	clients/cli/cmd_render.c \
	clients/cli/cmd_scenes.c \
	clients/cli/cmd_top.c \
	clients/cli/cmd_update.c \
	clients/cli/command.h \
	clients/cli/download.c clients/cli/download.h \
	clients/cli/follow.c clients/cli/follow.h \
	clients/cli/house.c clients/cli/house.h \
	clients/cli/image_file.c clients/cli/image_file.h \
	clients/cli/interrupt.c clients/cli/interrupt.h \
	clients/cli/memory_file.c clients/cli/memory_file.h \
	clients/cli/options.c clients/cli/options.h \
	clients/cli/order.c clients/cli/order.h \
	clients/cli/outlook.c clients/cli/outlook.h \
	clients/cli/output.c clients/cli/output.h \
	clients/cli/pixel.c clients/cli/pixel.h \
	clients/cli/problem.c clients/cli/problem.h \
	clients/cli/progress.c clients/cli/progress.h \
	clients/cli/recolour.c clients/cli/recolour.h \
	clients/cli/screen.c clients/cli/screen.h \
	clients/cli/session.c clients/cli/session.h \
	clients/cli/spawn.c clients/cli/spawn.h \
	clients/cli/sse.c clients/cli/sse.h \
	clients/cli/table.c clients/cli/table.h \
	clients/cli/tev.c clients/cli/tev.h \
	clients/cli/tev_packet.c clients/cli/tev_packet.h \
	clients/cli/tev_stream.c clients/cli/tev_stream.h \
	clients/cli/upload.c clients/cli/upload.h \
	clients/cli/uri.c clients/cli/uri.h
libglintcli_a_CPPFLAGS = $(AM_CPPFLAGS) -DGLINT_LIBEXECDIR='"$(pkglibexecdir)"'

bashcompdir = $(datadir)/bash-completion/completions
dist_bashcomp_DATA = deploy/completion/glint

bin_PROGRAMS += glint
glint_SOURCES = clients/cli/main.c
glint_LDADD = $(CLI_LIBS)

bin_PROGRAMS += glint-demo-scene
glint_demo_scene_SOURCES = \
	clients/demo/bounces.c \
	clients/demo/compose.h \
	clients/demo/crowds.c \
	clients/demo/dice.h \
	clients/demo/document.c clients/demo/document.h \
	clients/demo/light.c \
	clients/demo/main.c \
	clients/demo/palette.c clients/demo/palette.h \
	clients/demo/scenes.c clients/demo/scenes.h \
	clients/demo/shapes.c clients/demo/shapes.h \
	clients/demo/shelves.c \
	clients/demo/still_life.c
glint_demo_scene_LDADD = $(CJSON_LIBS) -lm

# The viewer: plain files that glintd carries and serves as they are.
web_sources = \
	clients/web/api.js \
	clients/web/camera.js \
	clients/web/curve.js \
	clients/web/display-2d.js \
	clients/web/display-gl.js \
	clients/web/dom.js \
	clients/web/exr.js \
	clients/web/format.js \
	clients/web/half.js \
	clients/web/icon.svg \
	clients/web/index.html \
	clients/web/job-form.js \
	clients/web/job-panel.js \
	clients/web/jobs.js \
	clients/web/keys.js \
	clients/web/main.js \
	clients/web/mattes.js \
	clients/web/multipart.js \
	clients/web/outputs.js \
	clients/web/page.css \
	clients/web/picture.js \
	clients/web/plan.js \
	clients/web/problems.js \
	clients/web/recolour.js \
	clients/web/scenes.js \
	clients/web/session.js \
	clients/web/style.css \
	clients/web/tiles-worker.js \
	clients/web/tone.js \
	clients/web/upload.js \
	clients/web/viewport.js
EXTRA_DIST += $(web_sources) docs/viewer/convergence.jpg docs/viewer/live.jpg \
	docs/viewer/live.json docs/viewer/mattes.jpg docs/viewer/plan.jpg

clients/web/embedded.c: $(web_sources) build-aux/embed.awk
	$(AM_V_GEN)$(MKDIR_P) clients/web
	$(AM_V_at)( echo '#include "http/viewer.h"'; \
	  for f in $(web_sources); do printf 'file %s\n' $${f##*/}; \
	    od -An -v -tu1 $(top_srcdir)/$$f || exit 1; done | \
	  $(AWK) -f $(top_srcdir)/build-aux/embed.awk | \
	  $(SED) 's/glint_sources/glint_viewer/' ) >$@.t && mv $@.t $@

CLEANFILES += clients/web/embedded.c
