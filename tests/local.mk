# Tests print TAP. A unit test is one line here: its source is <name>.c, it links both libraries
# and cmocka.

if HAVE_CMOCKA
UNIT_TESTS = \
	tests/clients/test_sse \
	tests/clients/test_tev_packet \
	tests/clients/test_uri \
	tests/kernel/test_bsdf \
	tests/kernel/test_bsdf_density \
	tests/kernel/test_bsdf_layers \
	tests/kernel/test_bsdf_layers_density \
	tests/kernel/test_coverage \
	tests/kernel/test_dialects \
	tests/kernel/test_film_sums \
	tests/kernel/test_filter \
	tests/kernel/test_fresnel \
	tests/kernel/test_light \
	tests/kernel/test_math \
	tests/kernel/test_matte \
	tests/kernel/test_matte_shared \
	tests/kernel/test_matte_spill \
	tests/kernel/test_matte_steps \
	tests/kernel/test_medium \
	tests/kernel/test_motion_keys \
	tests/kernel/test_sampler \
	tests/kernel/test_texture \
	tests/render/test_adaptive \
	tests/render/test_bounces \
	tests/render/test_camera \
	tests/render/test_effects \
	tests/render/test_eq1 \
	tests/render/test_features \
	tests/render/test_film_capture \
	tests/render/test_film_merge \
	tests/render/test_film_restore \
	tests/render/test_coarse \
	tests/render/test_cones \
	tests/render/test_sketched \
	tests/render/test_flow \
	tests/render/test_many_lights \
	tests/render/test_matte_names \
	tests/render/test_mattes \
	tests/render/test_motion \
	tests/render/test_need \
	tests/render/test_placed \
	tests/render/test_precision \
	tests/render/test_resident \
	tests/render/test_transport \
	tests/unit/test_ahead \
	tests/unit/test_alias \
	tests/unit/test_arena \
	tests/unit/test_assets \
	tests/unit/test_compact \
	tests/unit/test_config \
	tests/unit/test_checkpoint \
	tests/unit/test_checkpoint_file \
	tests/unit/test_contract \
	tests/unit/test_cryptomatte \
	tests/unit/test_data_uri \
	tests/unit/test_device \
	tests/unit/test_dials \
	tests/unit/test_edit \
	tests/unit/test_energy \
	tests/unit/test_exr \
	tests/unit/test_film \
	tests/unit/test_film_file \
	tests/unit/test_film_forged \
	tests/unit/test_film_tiles \
	tests/unit/test_folders \
	tests/unit/test_forecast \
	tests/unit/test_front \
	tests/unit/test_knobs \
	tests/unit/test_accuracy_metric \
	tests/unit/test_accuracy_stat \
	tests/unit/test_frame \
	tests/unit/test_frames \
	tests/unit/test_http \
	tests/unit/test_http_streams \
	tests/unit/test_image_decode \
	tests/unit/test_image_exr \
	tests/unit/test_import \
	tests/unit/test_import_answer \
	tests/unit/test_import_gltf \
	tests/unit/test_import_gltf_materials \
	tests/unit/test_import_gltf_scene \
	tests/unit/test_import_gltf_morph \
	tests/unit/test_import_gltf_time \
	tests/unit/test_job \
	tests/unit/test_jobs \
	tests/unit/test_journal \
	tests/unit/test_json \
	tests/unit/test_json_lists \
	tests/unit/test_live \
	tests/unit/test_sketch \
	tests/unit/test_light_grid \
	tests/unit/test_log \
	tests/unit/test_memory \
	tests/unit/test_metrics \
	tests/unit/test_multipart \
	tests/unit/test_nearest \
	tests/unit/test_need \
	tests/unit/test_obj \
	tests/unit/test_order \
	tests/unit/test_ply \
	tests/unit/test_png \
	tests/unit/test_pose \
	tests/unit/test_pose_deform \
	tests/unit/test_problem \
	tests/unit/test_queue \
	tests/unit/test_range \
	tests/unit/test_scene \
	tests/unit/test_scene_extremes \
	tests/unit/test_scene_material \
	tests/unit/test_scene_mesh \
	tests/unit/test_scene_mutated \
	tests/unit/test_scene_primitives \
	tests/unit/test_scene_time \
	tests/unit/test_scene_trust \
	tests/unit/test_scene_write \
	tests/unit/test_scheduler \
	tests/unit/test_schema \
	tests/unit/test_status \
	tests/unit/test_stl \
	tests/unit/test_stop \
	tests/unit/test_store \
	tests/unit/test_vault \
	tests/unit/test_thread \
	tests/unit/test_tokens \
	tests/unit/test_turn

# Hard cases: one program for each group of claims that must hold whatever the scene.
STABILITY_TESTS = \
	tests/stability/test_degenerate \
	tests/stability/test_demo \
	tests/stability/test_environment \
	tests/stability/test_film \
	tests/stability/test_geometry \
	tests/stability/test_groups \
	tests/stability/test_invariants \
	tests/stability/test_light \
	tests/stability/test_media \
	tests/stability/test_rays \
	tests/stability/test_texture
check_PROGRAMS += $(UNIT_TESTS) $(STABILITY_TESTS)
endif
check_PROGRAMS += tests/accuracy/forecast tests/accuracy/frame_error tests/render/render_file tests/render/write_frame tests/unit/import_dump
scores = tests/accuracy/scores.c tests/accuracy/scores.h
offline = tests/render/offline.c tests/render/offline.h
picture = tests/render/picture.c tests/render/picture.h
things = tests/render/things.c tests/render/things.h $(picture)
tests_accuracy_forecast_SOURCES = tests/accuracy/forecast.c tests/accuracy/forecast_film.c \
	tests/accuracy/forecast_film.h $(scores) $(offline)
tests_render_render_file_SOURCES = tests/render/render_file.c $(offline)
tests_render_test_camera_SOURCES = tests/render/test_camera.c $(offline) $(picture)
tests_render_test_transport_SOURCES = tests/render/test_transport.c $(offline)
film_bytes = tests/unit/film_bytes.c tests/unit/film_bytes.h
tests_unit_test_film_file_SOURCES = tests/unit/test_film_file.c $(film_bytes)
tests_unit_test_film_forged_SOURCES = tests/unit/test_film_forged.c $(film_bytes)
tests_unit_test_film_SOURCES = tests/unit/test_film.c $(offline)
bounced = tests/render/bounced.c tests/render/bounced.h tests/stability/stable.c \
	tests/stability/stable.h $(offline) $(things)
tests_render_test_bounces_SOURCES = tests/render/test_bounces.c $(bounced)
tests_render_test_cones_SOURCES = tests/render/test_cones.c $(bounced)
tests_render_test_matte_names_SOURCES = tests/render/test_matte_names.c $(offline) $(things)
tests_render_test_mattes_SOURCES = tests/render/test_mattes.c $(offline) $(things)
tests_render_write_frame_LDADD = $(PROTOCOL_LIBS)

stable = tests/stability/stable.c tests/stability/stable.h $(offline)
effect_worlds = tests/render/effect_worlds.c tests/render/effect_worlds.h $(stable)
tests_render_test_effects_SOURCES = tests/render/test_effects.c $(effect_worlds)
revised = tests/render/revised.c tests/render/revised.h $(stable)
moving = tests/render/moving.c tests/render/moving.h $(stable)
filmed = tests/render/filmed.c tests/render/filmed.h $(stable)
tests_render_test_adaptive_SOURCES = tests/render/test_adaptive.c $(scores) $(filmed)
tests_render_test_film_restore_SOURCES = tests/render/test_film_restore.c $(filmed)
tests_render_test_coarse_SOURCES = tests/render/test_coarse.c $(filmed)
tests_render_test_sketched_SOURCES = tests/render/test_sketched.c $(filmed)
tests_render_test_film_merge_SOURCES = tests/render/test_film_merge.c $(filmed)
tests_render_test_film_capture_SOURCES = tests/render/test_film_capture.c $(filmed)
tests_render_test_flow_SOURCES = tests/render/test_flow.c $(moving)
tests_render_test_motion_SOURCES = tests/render/test_motion.c $(moving)
tests_render_test_eq1_SOURCES = tests/render/test_eq1.c $(bounced)
tests_render_test_features_SOURCES = tests/render/test_features.c $(stable)
tests_render_test_many_lights_SOURCES = tests/render/test_many_lights.c $(stable)
tests_render_test_need_SOURCES = tests/render/test_need.c $(stable)
tests_render_test_placed_SOURCES = tests/render/test_placed.c $(revised)
tests_render_test_precision_SOURCES = tests/render/test_precision.c $(stable)
tests_render_test_resident_SOURCES = tests/render/test_resident.c $(revised)
tests_stability_test_degenerate_SOURCES = tests/stability/test_degenerate.c $(stable)
tests_stability_test_demo_SOURCES = tests/stability/test_demo.c $(stable)
tests_stability_test_environment_SOURCES = tests/stability/test_environment.c $(stable)
tests_stability_test_film_SOURCES = tests/stability/test_film.c $(stable)
tests_stability_test_geometry_SOURCES = tests/stability/test_geometry.c $(stable)
tests_stability_test_groups_SOURCES = tests/stability/test_groups.c $(stable)
tests_stability_test_groups_LDFLAGS = $(AM_LDFLAGS) -Wl,--wrap=glint_launch
tests_stability_test_invariants_SOURCES = tests/stability/test_invariants.c $(stable) $(things)
tests_stability_test_light_SOURCES = tests/stability/test_light.c $(stable)
tests_stability_test_media_SOURCES = tests/stability/test_media.c $(stable)
tests_stability_test_rays_SOURCES = tests/stability/test_rays.c $(stable)
tests_stability_test_texture_SOURCES = tests/stability/test_texture.c $(stable)

# Measurements: built and run by name.
EXTRA_PROGRAMS += tests/accuracy/mattes tests/accuracy/ranks tests/accuracy/strips tests/accuracy/variance tests/bench/embree_share tests/bench/exr_tile tests/bench/matte_overhead \
	tests/bench/memory tests/bench/million_scene tests/bench/stream_load
tests_accuracy_mattes_SOURCES = tests/accuracy/mattes.c tests/accuracy/replay.c \
	tests/accuracy/replay_chao.c tests/accuracy/replay.h $(offline)
tests_accuracy_mattes_LDFLAGS = $(AM_LDFLAGS) -Wl,--wrap=glint_run_deposit_pixels \
	-Wl,--wrap=glint_carried_deposit
tests_accuracy_variance_SOURCES = tests/accuracy/variance.c tests/accuracy/replay.c \
	tests/accuracy/replay_chao.c tests/accuracy/replay.h $(offline)
tests_accuracy_variance_LDFLAGS = $(tests_accuracy_mattes_LDFLAGS)
tests_accuracy_ranks_SOURCES = tests/accuracy/ranks.c $(offline)
tests_accuracy_strips_SOURCES = tests/accuracy/strips.c tests/accuracy/subrays.c \
	tests/accuracy/subrays.h $(offline)
EXTRA_PROGRAMS += tests/bench/effects tests/bench/efficiency_frames tests/bench/precision
tests_bench_efficiency_frames_SOURCES = tests/bench/efficiency_frames.c $(offline)
tests_bench_precision_LDADD = libglintcli.a $(LDADD)
tests_bench_precision_SOURCES = tests/bench/precision.c tests/kernel/matte_double.h $(bench_waves)
tests_bench_effects_LDADD = libglintcli.a $(LDADD)
tests_bench_effects_SOURCES = tests/bench/effects.c tests/bench/bench.c tests/bench/bench.h \
	tests/bench/waves.c tests/bench/waves.h $(effect_worlds)
EXTRA_PROGRAMS += tests/bench/packing tests/bench/stages
tests_bench_packing_SOURCES = tests/bench/packing.c tests/bench/bench.c tests/bench/bench.h
bench_waves = tests/bench/bench.c tests/bench/bench.h tests/bench/waves.c tests/bench/waves.h \
	$(offline)
tests_bench_embree_share_LDADD = libglintcli.a $(LDADD)
tests_bench_embree_share_SOURCES = tests/bench/embree_share.c $(bench_waves)
tests_bench_embree_share_LDFLAGS = $(AM_LDFLAGS) -Wl,--wrap=glint_geometry_trace_wave \
	-Wl,--wrap=glint_geometry_shadow_wave
tests_bench_exr_tile_LDADD = $(PROTOCOL_LIBS)
tests_bench_matte_overhead_LDADD = libglintcli.a $(LDADD)
tests_bench_matte_overhead_SOURCES = tests/bench/matte_overhead.c $(bench_waves)
tests_bench_memory_SOURCES = tests/bench/memory.c $(offline)
tests_bench_million_scene_SOURCES = tests/bench/million_scene.c tests/bench/bench.c \
	tests/bench/bench.h
tests_bench_stages_LDADD = libglintcli.a $(LDADD)
EXTRA_PROGRAMS += tests/bench/peers/glint tests/bench/scaling
tests_bench_scaling_LDADD = libglintcli.a $(LDADD)
tests_bench_scaling_SOURCES = tests/bench/scaling.c $(bench_waves)
tests_bench_peers_glint_SOURCES = tests/bench/peers/glint.c $(offline)
tests_bench_stages_SOURCES = tests/bench/stages.c $(bench_waves)
tests_bench_stages_LDFLAGS = $(AM_LDFLAGS) -Wl,--wrap=glint_now

# Jobs over stand-ins for renders and scenes.
jobs_fixture = tests/unit/fake_render.c tests/unit/fake_render.h tests/unit/fake_control.c \
	tests/unit/fake_state.h tests/unit/fake_scene.c tests/unit/fake_scene.h \
	tests/unit/jobs_fixture.c tests/unit/jobs_fixture.h

tests_unit_test_import_SOURCES = tests/unit/test_import.c tests/unit/glb_maker.c \
	tests/unit/glb_maker.h
gltf_expect = tests/unit/glb_maker.c tests/unit/glb_maker.h tests/unit/gltf_expect.c \
	tests/unit/gltf_expect.h
tests_unit_test_import_gltf_SOURCES = tests/unit/test_import_gltf.c $(gltf_expect)
tests_unit_test_import_gltf_materials_SOURCES = tests/unit/test_import_gltf_materials.c \
	$(gltf_expect)
tests_unit_test_import_gltf_scene_SOURCES = tests/unit/test_import_gltf_scene.c $(gltf_expect)
tests_unit_test_import_gltf_morph_SOURCES = tests/unit/test_import_gltf_morph.c \
	tests/unit/gltf_moving.c tests/unit/gltf_moving.h $(gltf_expect)
tests_unit_test_import_gltf_time_SOURCES = tests/unit/test_import_gltf_time.c \
	tests/unit/gltf_moving.c tests/unit/gltf_moving.h $(gltf_expect)
tests_unit_test_checkpoint_SOURCES = tests/unit/test_checkpoint.c $(jobs_fixture)
tests_unit_test_checkpoint_file_LDFLAGS = $(AM_LDFLAGS) -Wl,--wrap=fsync -Wl,--wrap=rename \
	-Wl,--wrap=glint_render_film
tests_unit_test_jobs_SOURCES = tests/unit/test_jobs.c $(jobs_fixture)
tests_unit_test_live_SOURCES = tests/unit/test_live.c $(jobs_fixture)
tests_unit_test_sketch_SOURCES = tests/unit/test_sketch.c $(jobs_fixture)
tests_unit_test_need_SOURCES = tests/unit/test_need.c $(jobs_fixture)
pose_scene = tests/unit/pose_scene.c tests/unit/pose_scene.h
tests_unit_test_pose_SOURCES = tests/unit/test_pose.c $(pose_scene)
tests_unit_test_pose_deform_SOURCES = tests/unit/test_pose_deform.c $(pose_scene)
scene_text = tests/unit/scene_text.c tests/unit/scene_text.h
tests_unit_test_scene_SOURCES = tests/unit/test_scene.c $(scene_text)
tests_unit_test_scene_extremes_SOURCES = tests/unit/test_scene_extremes.c $(scene_text)
tests_unit_test_scene_material_SOURCES = tests/unit/test_scene_material.c $(scene_text)
tests_unit_test_scene_mesh_SOURCES = tests/unit/test_scene_mesh.c $(scene_text)
tests_unit_test_scene_mutated_SOURCES = tests/unit/test_scene_mutated.c $(scene_text)
tests_unit_test_scene_primitives_SOURCES = tests/unit/test_scene_primitives.c $(scene_text)
tests_unit_test_scene_time_SOURCES = tests/unit/test_scene_time.c $(scene_text)
tests_unit_test_scene_trust_SOURCES = tests/unit/test_scene_trust.c $(scene_text)
tests_unit_test_scene_write_SOURCES = tests/unit/test_scene_write.c $(scene_text)
tests_unit_test_scheduler_SOURCES = tests/unit/test_scheduler.c $(jobs_fixture)
tests_unit_test_order_SOURCES = tests/unit/test_order.c $(offline)
tests_unit_test_obj_SOURCES = tests/unit/test_obj.c tests/unit/model_expect.h
tests_unit_test_ply_SOURCES = tests/unit/test_ply.c tests/unit/model_expect.h
tests_unit_test_stl_SOURCES = tests/unit/test_stl.c tests/unit/model_expect.h
tests_unit_test_stop_SOURCES = tests/unit/test_stop.c $(jobs_fixture)
tests_unit_test_store_SOURCES = tests/unit/test_store.c tests/unit/fake_scene.c \
	tests/unit/fake_scene.h
served = tests/unit/http_fixture.c tests/unit/http_fixture.h tests/unit/fake_house.c \
	tests/unit/fake_house.h
tests_unit_test_http_SOURCES = tests/unit/test_http.c $(served)
tests_unit_test_http_streams_SOURCES = tests/unit/test_http_streams.c $(served)
tests_accuracy_frame_error_LDADD = libglintcli.a $(PROTOCOL_LIBS)
tests_unit_test_accuracy_metric_LDADD = libglintcli.a $(LDADD)
tests_unit_test_accuracy_stat_LDADD = libglintcli.a $(LDADD)
tests_clients_test_sse_LDADD = libglintcli.a $(LDADD)
tests_clients_test_tev_packet_LDADD = libglintcli.a $(LDADD)
tests_clients_test_uri_LDADD = libglintcli.a $(LDADD)

# *.py and *.sh; shared Python modules and data of tests go to dist_check_DATA.
SCRIPT_TESTS = \
	tests/clients/blender_recolour.py \
	tests/clients/cli_completion.py \
	tests/clients/cli_daemon.py \
	tests/clients/cli_accuracy.py \
	tests/clients/cli_bundle.py \
	tests/clients/cli_identity.py \
	tests/clients/cli_merge.py \
	tests/clients/cli_jobs.py \
	tests/clients/cli_recolor.py \
	tests/clients/cli_render.py \
	tests/clients/cli_tev.py \
	tests/clients/cli_through.py \
	tests/clients/cli_update.py \
	tests/clients/cli_usage.py \
	tests/clients/demo_scene.py \
	tests/clients/viewer.py \
	tests/clients/walkthrough.py \
	tests/http/test_accuracy.py \
	tests/http/test_auth.py \
	tests/http/test_contract.py \
	tests/http/test_daemon.py \
	tests/http/test_formats.py \
	tests/http/test_hostile.py \
	tests/http/test_jobs.py \
	tests/http/test_kill9.py \
	tests/http/test_metrics.py \
	tests/http/test_requests.py \
	tests/http/test_restart.py \
	tests/http/test_scenes.py \
	tests/http/test_service.py \
	tests/http/test_state.py \
	tests/http/test_streams.py \
	tests/http/test_unit.py \
	tests/http/test_updates.py \
	tests/accuracy/test_claims.py \
	tests/accuracy/test_docs.py \
	tests/mutation/test_table.py \
	tests/render/test_cryptomatte_node.py \
	tests/bench/test_peers_measure.py \
	tests/render/test_exr_readers.py \
	tests/render/test_peers.py \
	tests/stability/test_rows.py \
	tests/unit/headers.sh \
	tests/unit/import_corpora.py \
	tests/unit/manual.sh

TESTS += $(UNIT_TESTS) $(STABILITY_TESTS) $(SCRIPT_TESTS)
dist_check_SCRIPTS += $(SCRIPT_TESTS) tests/run-tap tests/accuracy/strips_pictures tests/accuracy/strips_plot.py tests/accuracy/choose tests/accuracy/events.py tests/accuracy/levels tests/accuracy/policies tests/accuracy/policies_plot.py tests/clients/blender_picture tests/clients/viewer_live tests/clients/viewer_pictures tests/http/kill9 tests/http/soak tests/bench/efficiency tests/bench/live tests/bench/run tests/bench/startup tests/bench/stream tests/bench/update_latency tests/bench/vectorised \
	tests/stability/matrix tests/stability/nightly
dist_check_DATA += tests/bench/README.md tests/bench/every_effect.py tests/bench/history.csv tests/bench/million_blend.py \
	tests/clients/blender_cryptomatte.py tests/clients/browser.py tests/clients/cli.py tests/clients/fake_daemon.py tests/http/contract.toml \
	tests/http/contract_hooks.py tests/http/daemon.py tests/http/lasting.py tests/http/sandbox.py \
	tests/http/rendering_watch.py tests/http/soak_plot.py \
	tests/kernel/check.h tests/odds.h tests/kernel/probe.cl tests/kernel/density.h tests/kernel/surface.h \
	tests/render/cryptomatte.py tests/render/cryptomatte_node.py tests/render/tools.py \
	tests/render/peers/balls-white.json tests/render/peers/balls.json \
	tests/render/peers/compare.py tests/render/peers/cornell.json \
	tests/render/peers/cycles_render.py tests/render/peers/mitsuba_render.py \
	tests/render/peers/reference.py tests/render/peers/references.sh \
	tests/render/peers/scenes.py \
	tests/sanitizers/lsan.supp tests/sanitizers/tsan.supp tests/stability/rows \
	tests/stability/programs.py tests/stability/table.py tests/tap.py

dist_check_SCRIPTS += tests/mutation/run tests/bench/effects_table
EXTRA_DIST += docs/effects/README.md docs/effects/effects.json docs/precision/README.md \
	docs/precision/precision.json docs/mutation/table.csv docs/mutation/table.md
dist_check_DATA += tests/kernel/matte_double.h tests/mutation/faults.toml tests/mutation/filter.c tests/mutation/table.py

dist_check_SCRIPTS += tests/bench/peers_install tests/bench/peers/peers.py
dist_check_DATA += tests/bench/peers/crews.py tests/bench/peers/cycles_serve.py \
	tests/bench/peers/luxcore_serve.py tests/bench/peers/measure.py \
	tests/bench/peers/mitsuba_serve.py tests/bench/peers/neutral.py \
	tests/bench/peers/renderers.txt tests/bench/peers/report.py tests/bench/peers/serve.py \
	tests/bench/peers/worlds.py

TEST_EXTENSIONS = .py .sh
TAP_DRIVER = env AM_TAP_AWK='$(AWK)' $(SHELL) $(top_srcdir)/build-aux/tap-driver.sh
LOG_DRIVER = $(TAP_DRIVER)
PY_LOG_DRIVER = $(TAP_DRIVER)
SH_LOG_DRIVER = $(TAP_DRIVER)
LOG_COMPILER = $(SHELL) $(top_srcdir)/tests/run-tap
PY_LOG_COMPILER = $(SHELL) $(top_srcdir)/tests/run-tap $(PYTHON)
SH_LOG_COMPILER = $(SHELL) $(top_srcdir)/tests/run-tap $(SHELL)

# intercept_tls_get_addr: the leak checker crashes on the storage of kernels that were unloaded.
AM_TESTS_ENVIRONMENT = \
	CMOCKA_MESSAGE_OUTPUT=TAP; export CMOCKA_MESSAGE_OUTPUT; \
	GLINTD='$(abs_top_builddir)/glintd'; export GLINTD; \
	GLINT_FORESEE=no; export GLINT_FORESEE; \
	XDG_CACHE_HOME='$(abs_top_builddir)/tests/cache'; export XDG_CACHE_HOME; \
	GLINT='$(abs_top_builddir)/glint'; export GLINT; \
	: "$${GLINT_SCENES:=$(abs_top_srcdir)/../shared/scenes}"; export GLINT_SCENES; \
	top_srcdir='$(top_srcdir)'; export top_srcdir; \
	GLINT_BUILD='$(abs_top_builddir)'; export GLINT_BUILD; \
	PYTHONPATH='$(abs_top_srcdir)/tests'; export PYTHONPATH; \
	PYTHONDONTWRITEBYTECODE=1; export PYTHONDONTWRITEBYTECODE; \
	supp='$(abs_top_srcdir)/tests/sanitizers'; \
	LSAN_OPTIONS="suppressions=$$supp/lsan.supp:print_suppressions=0"; export LSAN_OPTIONS; \
	ASAN_OPTIONS=intercept_tls_get_addr=0; export ASAN_OPTIONS; \
	TSAN_OPTIONS="suppressions=$$supp/tsan.supp"; export TSAN_OPTIONS; \
	UBSAN_OPTIONS=print_stacktrace=1; export UBSAN_OPTIONS; \
	GLINT_COMPILE='$(CC) -D_GNU_SOURCE $(AM_CPPFLAGS) $(CPPFLAGS) $(AM_CFLAGS) $(CFLAGS)'; \
	export GLINT_COMPILE;

# make check with a closing line that any continuous integration can read, also on failure.
ci-check:
	@rc=0; $(MAKE) $(AM_MAKEFLAGS) check || rc=$$?; \
	count() { cat $(TEST_LOGS:.log=.trs) 2>/dev/null | grep -c "^:test-result: *\($$1\)"; }; \
	p=`count 'PASS\|XFAIL'`; f=`count 'FAIL\|XPASS\|ERROR'`; s=`count SKIP`; \
	echo "$$p passed, $$f failed, $$s skipped"; exit $$rc
.PHONY: ci-check

# Statistical tests with fresh seeds.
check-nightly: $(check_PROGRAMS)
	GLINT_BUILD='$(abs_top_builddir)' PYTHONDONTWRITEBYTECODE=1 $(PYTHON) $(srcdir)/tests/stability/nightly
.PHONY: check-nightly

# Compiled kernels, kept from run to run.
clean-local:
	rm -rf tests/cache tests/*/*.results-*.json
