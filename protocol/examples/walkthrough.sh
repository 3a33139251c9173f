#!/bin/sh
# walkthrough.sh [URL] - all that a glint daemon does, by curl alone, from top to bottom.
#
#   glintd &
#   sh walkthrough.sh http://127.0.0.1:7745
#
# Files go to ./walkthrough. It is also a test: an answer that is not what it says here ends it.
set -eu
server=${1:-${GLINT_SERVER:-http://127.0.0.1:7745}}
examples=$(cd "$(dirname "$0")" && pwd)
mkdir -p walkthrough
cd walkthrough

# Every call below is `ask`: curl that fails where the daemon answers with an error. Where a daemon
# has tokens each call would carry one more header: -H "Authorization: Bearer $GLINT_TOKEN".
ask() { curl --silent --show-error --fail-with-body --max-time 120 "$@"; }

# The first member of that name in a JSON answer, for those without jq: `member state <job.json`.
member() { grep -o "\"$1\":\"\{0,1\}[^\",}]*" | sed 's/^[^:]*:"\{0,1\}//;q'; }

step() { printf '\n== %s\n' "$*"; }
expect() { [ "$1" = "$2" ] || { echo "expected $2, not $1" >&2; exit 1; }; }

step 'Is it there, and what can it do?'
ask "$server/healthz"
ask "$server/v1" >capabilities.json
echo && member version <capabilities.json

step 'Put a scene: its bytes, under a name of your choice'
# A scene is a GLB, a glTF with its files, OBJ, PLY, STL or, as here, glint's own JSON:
#   curl -T house.glb -H 'Content-Type: model/gltf-binary' $server/v1/scenes/house
ask -T "$examples/scene.json" -H 'Content-Type: application/json' "$server/v1/scenes/stage" \
    >scene.json
revision=$(member revision <scene.json)
echo "stage is at revision $revision"

step 'Submit a job: what to render of it'
cat >job.json <<'JSON'
{
  "scene": "stage", "camera": "main", "name": "walkthrough",
  "resolution": [160, 90], "stop": {"samples": 16},
  "outputs": ["beauty", "crypto_object", "crypto_material", "depth", "normal", "albedo"]
}
JSON
# The key makes the submission safe to repeat: whoever does not hear the answer asks again.
key=walkthrough-$$-$(date +%s)
ask -d @job.json -H 'Content-Type: application/json' -H "Idempotency-Key: $key" \
    "$server/v1/jobs" >submitted.json
ask -d @job.json -H 'Content-Type: application/json' -H "Idempotency-Key: $key" \
    "$server/v1/jobs" >again.json
id=$(member id <submitted.json)
expect "$(member id <again.json)" "$id"
job=$server/v1/jobs/$id
echo "job $id is $(member state <submitted.json)"

step 'Follow it: server-sent events until it is done'
ask -N "$job/events" >events.txt
sed -n 's/^event: //p' events.txt | sort | uniq -c
# After a lost connection the stream goes on behind the last event that was read; 204: no more come.
last=$(sed -n 's/^id: //p' events.txt | tail -n 1)
expect "$(ask -H "Last-Event-ID: $last" -o /dev/null -w '%{http_code}' "$job/events")" 204

step 'Fetch the frame: EXR with every output, PNG of one for the eye'
ask -o frame.exr "$job/frame.exr?wait=done"
ask -o beauty.exr "$job/frame.exr?outputs=beauty"
ask -o frame.png "$job/frame.png?exposure=0.5&tonemap=reinhard"
ls -l frame.exr beauty.exr frame.png
# A finished frame does not change: the second time its entity tag saves the transfer, and a part
# of it can be asked for.
etag=$(ask -o /dev/null -D - "$job/frame.exr" | tr -d '\r' | sed -n 's/^[Ee][Tt]ag: //p')
expect "$(ask -H "If-None-Match: $etag" -o /dev/null -w '%{http_code}' "$job/frame.exr")" 304
expect "$(ask -r 0-3 "$job/frame.exr" | od -An -tx1 | tr -d ' ')" 762f3101

step 'Stream tiles: each part of the stream is an EXR of its own'
# Of a running job they come as they are rendered; a job that is done sends all of them and ends.
ask -N -o tiles.multipart "$job/tiles"
grep -a '^Glint-Tile: ' tiles.multipart | tr -d '\r'

step 'What is in the picture: names, mattes, and what is under a pixel'
ask "$job/mattes?layer=object" >mattes.json
ask -G --data-urlencode 'name=hero ball' -d layer=object -o matte.png "$job/matte.png"
ask -G --data-urlencode 'name=hero ball' --data-urlencode 'name=drop' -o matte.exr "$job/matte.exr"
ask "$job/pick?x=60&y=50" | tee pick.json
echo

step 'What was simulated, why, and at which price; how the error fell'
ask "$job/plan" >plan.json
ask "$job/convergence" >convergence.json
member error <convergence.json

step 'More samples: a finished job goes on, it does not start again'
ask -X PATCH -d '{"stop": {"samples": 24}}' -H 'Content-Type: application/merge-patch+json' \
    "$job" >more.json
ask -o frame24.exr "$job/frame.exr?wait=done"
ask "$job" >job24.json
expect "$(member samples <job24.json)" 24

step 'Split a frame over machines: films of sample ranges add up to the frame of one run'
# Each half could be rendered by another daemon that has the scene. Regions split a frame as well.
half() {
    ask -d '{"scene": "stage", "resolution": [160, 90],
             "sample_range": ['"$1"']}' -H 'Content-Type: application/json' "$server/v1/jobs"
}
first=$server/v1/jobs/$(half '0, 8' | member id)
second=$server/v1/jobs/$(half '8, 16' | member id)
ask -o first.film "$first/film?wait=done"
ask -o second.film "$second/film?wait=done"
# Films are added by the client: no daemon is needed for it.
if command -v glint >/dev/null; then
    glint merge first.film second.film -o merged.exr
fi

step 'Edit the scene: a merge patch; only what it touches is built anew'
# If-Match: only if nobody else was faster. null removes a member.
ask -X PATCH -d '{"materials": {"gold": {"roughness": 0.6}}, "lights": {"sun": null}}' \
    -H 'Content-Type: application/merge-patch+json' -H "If-Match: \"$revision\"" \
    "$server/v1/scenes/stage" >edited.json
sed -n 's/.*\("changes":.*\)/\1/p' edited.json
expect "$(curl -s -o stale.json -w '%{http_code}' -X PATCH -d '{}' -H "If-Match: \"$revision\"" \
    -H 'Content-Type: application/merge-patch+json' "$server/v1/scenes/stage")" 412

step 'A live job follows the scene and its own camera'
ask -d '{"scene": "stage", "live": true, "resolution": [160, 90], "stop": {"samples": 4}}' \
    -H 'Content-Type: application/json' "$server/v1/jobs" >live.json
live=$server/v1/jobs/$(member id <live.json)
until [ "$(ask "$live" | member samples)" = 4 ]; do sleep 0.1; done
ask -o live1.png "$live/frame.png"
ask -X PATCH -H 'Content-Type: application/merge-patch+json' "$live" >/dev/null -d '{"camera":
    {"yfov": 0.5, "transform": {"translation": [1.2, 1.4, 4.4], "rotation": [-0.1, 0.13, 0.013, 0.986]}}}'
until [ "$(ask "$live" | member samples)" = 4 ] &&
    ask -o live2.png "$live/frame.png" && ! cmp -s live1.png live2.png; do sleep 0.1; done
echo 'the view has moved'

step 'Cancel a job, then forget it'
expect "$(ask -X DELETE -o /dev/null -w '%{http_code}' "$live")" 202
expect "$(ask "$live" | member state)" cancelled
expect "$(ask -X DELETE -o /dev/null -w '%{http_code}' "$live")" 204
expect "$(curl -s -o /dev/null -w '%{http_code}' "$live")" 404

step 'An error names every fault, with a pointer to where it is'
expect "$(curl -s -o problem.json -w '%{http_code}' -H 'Content-Type: application/json' \
    -d '{"scene": "stage", "smaples": 64, "resolution": [0, 90]}' "$server/v1/jobs")" 422
cat problem.json
echo

step 'How the house fares: for people, and for Prometheus'
ask "$server/v1/stats" >stats.json
ask "$server/v1/jobs?limit=10" >jobs.json
ask "$server/metrics" | grep '^glint_jobs{'

step 'Done; everything is in ./walkthrough'
