# The clients; they link the protocol library and never the daemon's.

if HAVE_GLINT
bin_PROGRAMS += glint
endif
glint_SOURCES = clients/cli/main.c
glint_LDADD = $(PROTOCOL_LIBS) $(CURL_LIBS)
