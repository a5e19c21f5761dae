#!/bin/sh
# Everything to be known of an adapter, in one go, from executables that `cargo xtask gpu -o FOLDER` has put beside this script:
#
#     FOLDER/gpu.sh OUT [OPTION...]
#
# Measures (the options are those of benches/gpu), walks bounce rays, runs the criterion benches of the device, then the tests, one file after the other, until LIMIT
# seconds (460, or the variable's) are over. A step that fails, hangs or is missing is recorded, and the next one begins. OUT gets report.md, gpu.json and logs.txt.
here=$(cd "$(dirname "$0")" && pwd)
out=${1:?say where the report goes: gpu.sh OUT}
shift
mkdir -p "$out" || exit 1
out=$(cd "$out" && pwd)
end=$(($(date +%s) + ${LIMIT:-460}))
steps="| step | outcome | seconds |
|---|---|---|
"
: > "$out/logs.txt"

write_report() {
    {
        echo "# Surelight on this machine"
        echo
        echo "commit $(cat "$here/COMMIT" 2> /dev/null), $(date -u '+%Y-%m-%d %H:%M UTC'), $(uname -sm)"
        command -v nvidia-smi > /dev/null && nvidia-smi --query-gpu=name,driver_version,memory.total --format=csv,noheader
        echo
        printf '%s\n' "$steps"
        cat "$out/gpu.md" 2> /dev/null
        echo
        echo "## Other figures"
        echo
        echo '```'
        grep -E '^(\||upload/|walk/|sampler/|conditions)|time: |thrpt: ' "$out/logs.txt" | grep -v '^|--'
        echo '```'
    } > "$out/report.md"
}

# step NAME SECONDS COMMAND...: at most so many seconds, and no more than are left.
step() {
    name=$1
    most=$2
    shift 2
    left=$((end - $(date +%s)))
    began=$(date +%s)
    if [ ! -x "$1" ]; then
        outcome="missing"
    elif [ "$left" -lt 5 ]; then
        outcome="not begun: the time was up"
    else
        [ "$left" -lt "$most" ] && most=$left
        echo "== $name" >> "$out/logs.txt"
        timeout -k 5 "$most" "$@" >> "$out/logs.txt" 2>&1
        code=$?
        case $code in
            0) outcome="passed" ;;
            124 | 137) outcome="stopped after $most s" ;;
            *) outcome="FAILED ($code)" ;;
        esac
    fi
    steps="$steps| $name | $outcome | $(($(date +%s) - began)) |
"
    echo "$name: $outcome"
    write_report
}

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export CRITERION_HOME="$scratch"
cd "$scratch" || exit 1

set -- "$@"
for scene in "$here"/scenes/*.glb "$here"/scenes/*/*.gltf; do
    [ -f "$scene" ] && set -- "$@" "$scene"
done
step "measurements" 260 "$here/gpu" -o "$out" "$@"
step "bounce rays" 60 "$here/bounces"
step "device benches" 60 "$here/device" --bench
for test in "$here"/tests/*; do
    step "tests: $(basename "$test")" 120 "$test"
done
rm -f "$out/gpu.md"
echo "the report is $out/report.md"
