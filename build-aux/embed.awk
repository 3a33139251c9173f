# Turns "file NAME" lines, each followed by the decimal bytes of that file as od prints them, into
# the C table that daemon/device/sources.h declares.

$1 == "file" {
    if (files++)
        print "};"
    name[files] = $2
    printf "static const unsigned char bytes_%d[] = {\n", files
    next
}

{
    for (i = 1; i <= NF; i++)
        printf "%s,", $i
    print ""
}

END {
    if (files)
        print "};"
    print "const struct glint_source glint_sources[] = {"
    for (i = 1; i <= files; i++)
        printf "    {\"%s\", (const char *)bytes_%d, sizeof bytes_%d},\n", name[i], i, i
    print "    {0, 0, 0},\n};"
}
