# Units for systemd, in $(systemdsystemunitdir); without one they are only built.

noinst_DATA = deploy/systemd/glintd.service
if HAVE_UNIT_FOLDER
systemdsystemunit_DATA = deploy/systemd/glintd.service deploy/systemd/glintd.socket
endif
dist_doc_DATA = deploy/systemd/glintd-gpu.conf
EXTRA_DIST += deploy/systemd/glintd.service.in deploy/systemd/glintd.socket
CLEANFILES += deploy/systemd/glintd.service

deploy/systemd/glintd.service: deploy/systemd/glintd.service.in Makefile
	$(AM_V_GEN)$(MKDIR_P) $(@D) && \
	$(SED) 's|@bindir[@]|$(bindir)|' '$(srcdir)/deploy/systemd/glintd.service.in' >$@.part && \
	mv $@.part $@
