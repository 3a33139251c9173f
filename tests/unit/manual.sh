#!/bin/sh
# Every option that --help shows is in the manual page.
n=0
# documents PAGE COMMAND...
documents() {
    page=$top_srcdir/deploy/man/$1
    shift
    n=$((n + 1))
    claim="$n - the manual has every option of $(basename "$1")${2:+ $2}"
    if [ ! -x "$1" ]; then
        echo "ok $claim # SKIP not built"
        return
    fi
    missing=
    for option in $("$@" --help | grep -o -- '--[a-z][a-z-]*' | sort -u); do
        sed 's/\\-/-/g' "$page" | grep -q -- "$option\>" || missing="$missing $option"
    done
    [ -z "$missing" ] && echo "ok $claim" || echo "not ok $claim: not$missing"
}

documents glintd.8 "$GLINTD"
for command in render submit put scenes update jobs watch top get cancel mattes matte pick recolor \
    plan merge accuracy; do
    documents glint.1 "$GLINT" $command
done

n=$((n + 1))
missing=
for setting in $(sed -n 's/^    {"\([a-z_]*\)", [A-Z]*, AT.*/\1/p' "$top_srcdir/daemon/settings.c"); do
    grep -q "^\.BR $setting\>\|, \" $setting\>" "$top_srcdir/deploy/man/glintd.conf.5" ||
        missing="$missing $setting"
done
[ -z "$missing" ] && echo "ok $n - the manual has every setting" ||
    echo "not ok $n - the manual has every setting: not$missing"
echo "1..$n"
