#!/bin/sh
# Each header compiles alone: it includes what it needs.
build=$PWD
cd "$top_srcdir" || exit 99
n=0
for header in protocol/*.h daemon/*.h daemon/*/*.h kernels/*.h clients/*/*.h; do
    [ -f "$header" ] || continue
    n=$((n + 1))
    if (cd "$build" && echo "#include \"$header\"" | eval "$GLINT_COMPILE" -x c -fsyntax-only -); then
        echo "ok $n - $header compiles alone"
    else
        echo "not ok $n - $header compiles alone"
    fi
done
echo "1..$n"
