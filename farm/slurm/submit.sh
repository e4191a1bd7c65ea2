#!/bin/bash
# Splits a job of glanz into the tasks of a Slurm array and joins them, to the bits of one run.
#
#   submit.sh picture SCENE PICTURE PARTS WORK [OPTIONS]   glanz render
#   submit.sh lux SCENE FOLDER PARTS WORK [OPTIONS]        glanz illuminate; OPTIONS must have --rays N
#   submit.sh bake SCENE MODEL PARTS WORK [OPTIONS]        glanz bake
#
# WORK is a folder that all nodes share: it gets the checkpoints of the parts and their output. OPTIONS are those of the
# command of glanz, such as --spp 4096. The variable GLANZ names the program; sbatch takes its own settings from variables,
# such as SBATCH_PARTITION, SBATCH_TIMELIMIT, SBATCH_CPUS_PER_TASK. Prints the numbers of the jobs.
#
# A task writes its state every 30 seconds, and when Slurm announces its end (the time limit, or preemption) a minute
# before. It goes on from there when it starts again: after an announced end, after it was killed (three times), or when
# its node failed. The same command, given again after a failure, computes only what the checkpoints lack.
set -euo pipefail

fail() {
    echo "error: $*" >&2
    exit 1
}

usage() {
    sed -n '4,6s/^# *//p' "$0" >&2
    exit 2
}

# Runs glanz; after an announced end, or if it is killed, the task is queued again.
run() {
    trap 'ended=1; kill -TERM "$child" 2>/dev/null || true' TERM
    ended= code=0
    "$glanz" "$@" &
    child=$!
    wait "$child" || code=$?
    if [ -n "$ended" ]; then
        # The wait ended by the signal, the program a little later.
        code=0
        wait "$child" || code=$?
    fi
    case $code in
        0) return ;;
        130) requeue ;;
        137) [ "${SLURM_RESTART_COUNT:-0}" -ge 3 ] || requeue ;;
    esac
    exit "$code"
}

requeue() {
    task=${SLURM_ARRAY_JOB_ID:-$SLURM_JOB_ID}${SLURM_ARRAY_TASK_ID:+_$SLURM_ARRAY_TASK_ID}
    echo "task $task goes on from its checkpoint" >&2
    scontrol requeue "$task"
    # Slurm ends this script.
    sleep 60
}

# Of a bake, all parts need all direct light, which is divided before.
direct() {
    number=$SLURM_ARRAY_TASK_ID
    run bake "$scene" "$@" --part "$number/$parts" --direct-only --checkpoint "$work/direct-$number.glanz" --resume
}

join_direct() {
    checkpoints=()
    for number in $(seq "$parts"); do checkpoints+=("$work/direct-$number.glanz"); done
    run merge "${checkpoints[@]}" --checkpoint "$work/direct.glanz"
}

part() {
    number=$SLURM_ARRAY_TASK_ID
    [ "$mode" != bake ] || set -- "$@" --light-in "$work/direct.glanz"
    run "$command" "$scene" "$@" --part "$number/$parts" --checkpoint "$work/part-$number.glanz" --resume
}

join() {
    checkpoints=()
    for number in $(seq "$parts"); do checkpoints+=("$work/part-$number.glanz"); done
    if [ "$mode" = picture ]; then
        run merge "${checkpoints[@]}" -o "$output"
    else
        run merge "${checkpoints[@]}" --checkpoint "$work/whole.glanz"
        run "$command" "$scene" -o "$output" "$@" --checkpoint "$work/whole.glanz" --resume
    fi
}

# Submits an action after the one before, and adds its number to those of the jobs.
queue() {
    action=$1
    shift
    settings=(--job-name="glanz-$mode-$action" --requeue --open-mode=append --signal=B:TERM@60 --output="$work/$action.log")
    [[ $action == join* ]] || settings+=(--array="1-$parts" --output="$work/$action-%a.log")
    [ ${#jobs[@]} = 0 ] || settings+=(--dependency="afterok:${jobs[-1]}" --kill-on-invalid-dep=yes)
    jobs+=("$(sbatch --parsable "${settings[@]}" "$0" "$action" "$mode" "$scene" "$output" "$parts" "$work" "$@")")
}

submit() {
    mkdir -p "$work"
    jobs=()
    if [ "$mode" = bake ]; then
        queue direct "$@"
        queue join_direct "$@"
    fi
    queue part "$@"
    queue join "$@"
    echo "${jobs[*]}"
}

glanz=${GLANZ:-glanz}
action=submit
case ${1:-} in
    part | join | direct | join_direct) action=$1; shift ;;
esac
[ $# -ge 5 ] || usage
mode=$1 scene=$2 output=$3 parts=$4 work=$5
shift 5
case $mode in
    picture) command=render ;;
    lux) command=illuminate ;;
    bake) command=bake ;;
    *) usage ;;
esac
if [ $action = submit ]; then
    command -v "$glanz" >/dev/null || fail "$glanz is not there; set GLANZ to the program"
    [ -f "$scene" ] || fail "$scene is not there"
    [[ $parts =~ ^[1-9][0-9]*$ ]] || fail "\"$parts\" is no number of parts"
    scene=$(realpath "$scene") output=$(realpath -m "$output") work=$(realpath -m "$work")
fi
$action "$@"
