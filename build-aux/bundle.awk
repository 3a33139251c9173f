# Makes an OpenAPI document whole: a schema that is a file ("Name: {$ref: schema/x.json}") is put in
# its place, JSON being YAML too, and references into it are led there.
#   awk -f bundle.awk DIR/openapi.yaml

function file_of(line) {
    sub(/.*\$ref: */, "", line)
    sub(/\}.*/, "", line)
    return line
}

function base(file) {
    sub(/.*\//, "", file)
    return file
}

function is_file(line) {
    return line ~ /^ +[A-Za-z]+: \{\$ref: schema\/[a-z]+\.json\}$/
}

function insert(component, file, line, other) {
    print "    " component ":"
    while ((getline line < (dir file)) > 0) {
        if (line ~ /"\$schema":/)
            continue
        gsub(/"#\//, "\"#/components/schemas/" component "/", line)
        for (other in place)
            gsub("\"" other "#/", "\"#/components/schemas/" place[other] "/", line)
        print "      " line
    }
    close(dir file)
}

BEGIN {
    dir = ARGV[1]
    sub(/[^\/]*$/, "", dir)
    while ((getline line < ARGV[1]) > 0)
        if (is_file(line)) {
            split(line, word, /[ :]+/)
            place[base(file_of(line))] = word[2]
        }
    close(ARGV[1])
}

is_file($0) {
    insert(place[base(file_of($0))], file_of($0))
    next
}

{ print }
