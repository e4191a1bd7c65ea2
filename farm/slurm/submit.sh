#!/bin/bash
# Splits a job of glanz into the tasks of a Slurm array and joins them, to the bits of one run.
#
#   submit.sh picture SCENE PICTURE PARTS WORK [OPTIONS]   glanz render
#   submit.sh lux SCENE FOLDER PARTS WORK [OPTIONS]        glanz illuminate; OPTIONS must have --rays N
#   submit.sh bake SCENE MODEL PARTS WORK [OPTIONS]        glanz bake
#
# WORK is a folder that all nodes share: it gets the checkpoints of the parts and their output. OPTIONS are those of the
# command of glanz, such as --spp 4096. The variable GLANZ names the program; GLANZ_SBATCH has options of sbatch, such as
# '--cpus-per-task 8 --mem 16G', and sbatch takes more from its own variables, such as SBATCH_PARTITION, SBATCH_TIMELIMIT.
# A task starts a thread for each of its processors. Prints the numbers of the jobs.
#
# A task writes its state soon after the start, every 30 seconds, and when Slurm announces the time limit, one or two minutes before. It goes on
# from there when it starts again: after the announcement, if it was killed before its fourth start, or when its node
# failed. The same command, given again after a failure, computes only what the checkpoints lack.
set -euo pipefail

fail() {
    echo "error: $*" >&2
    exit 1
}

usage() {
    sed -n '4,6s/^# *//p' "$0" >&2
    exit 2
}

# Runs glanz; after the announced end, or if it is killed, the task is queued again. A task that is cancelled is not.
run() {
    signalled= child= code=0
    [ -v before ] || before=$(progress)
    # The announcement is for this script alone. SIGTERM goes to all processes; a second one would end glanz before it has
    # saved its state.
    trap 'announced=1 signalled=1; [ -z "$child" ] || kill -TERM "$child" 2>/dev/null || true' USR1
    trap 'signalled=1' TERM
    [[ " $* " == *" --threads "* ]] || set -- "$@" --threads "${SLURM_CPUS_ON_NODE:-1}"
    "$glanz" "$@" &
    child=$!
    [ -z "$announced" ] || kill -TERM "$child" 2>/dev/null || true
    wait "$child" || code=$?
    # A signal ends the wait, the program ends a little later.
    while [ -n "$signalled" ]; do
        signalled= code=0
        wait "$child" || code=$?
    done
    case $code in
        0) return ;;
        130 | 143)
            if [ -n "$announced" ]; then
                [ "$(progress)" != "$before" ] || fail "nothing was saved before the time limit; give the task more time"
                requeue
            fi ;;
        137) [ "${SLURM_RESTART_COUNT:-0}" -ge 3 ] || requeue ;;
    esac
    exit "$code"
}

# Time and size of the task's checkpoint, which tell whether it has got on.
progress() {
    stat -c '%y %s' "$state" 2>/dev/null || true
}

requeue() {
    task=${SLURM_ARRAY_JOB_ID:-$SLURM_JOB_ID}${SLURM_ARRAY_TASK_ID:+_$SLURM_ARRAY_TASK_ID}
    echo "task $task goes on from its checkpoint" >&2
    # Incomplete: not if it has been cancelled meanwhile.
    scontrol requeue Incomplete "$task"
    # Slurm ends this script.
    sleep 60
}

# Of a bake, all parts need all direct light, which is divided before.
direct() {
    number=$SLURM_ARRAY_TASK_ID state=$work/direct-$number.glanz
    run bake "$scene" "$@" --part "$number/$parts" --direct-only --checkpoint "$state" --resume
}

join_direct() {
    state=$work/direct.glanz
    merge direct direct.glanz
}

part() {
    number=$SLURM_ARRAY_TASK_ID state=$work/part-$number.glanz
    [ "$mode" != bake ] || set -- "$@" --light-in "$work/direct.glanz"
    run "$command" "$scene" "$@" --part "$number/$parts" --checkpoint "$state" --resume
}

# What OPTIONS do to a finished picture, such as --denoise, is done here.
join() {
    state=$work/whole.glanz
    [ -f "$state" ] || merge part whole.glanz
    run "$command" "$scene" -o "$output" "$@" --checkpoint "$state" --resume
}

# Joins the checkpoints NAME-1, NAME-2 and so on into one. Short names, since the length of a command is limited.
merge() {
    cd "$work"
    checkpoints=()
    for number in $(seq "$parts"); do checkpoints+=("$1-$number.glanz"); done
    run merge "${checkpoints[@]}" --checkpoint "$2"
}

# Submits an action after the one before, and adds its number to those of the jobs.
queue() {
    action=$1
    shift
    settings=(--job-name="glanz-$mode-$action" --requeue --open-mode=append --signal=B:USR1@60 --output="$work/$action.log")
    [[ $action == join* ]] || settings+=(--array="1-$parts" --output="$work/$action-%a.log")
    [ ${#jobs[@]} = 0 ] || settings+=(--dependency="afterok:${jobs[-1]}" --kill-on-invalid-dep=yes)
    # shellcheck disable=SC2086 # GLANZ_SBATCH is a list.
    if ! id=$(sbatch --parsable ${GLANZ_SBATCH:-} "${settings[@]}" "$0" "$action" "$mode" "$scene" "$output" "$parts" "$work" "$@"); then
        [ ${#jobs[@]} = 0 ] || scancel "${jobs[@]}"
        exit 1
    fi
    # Of several clusters, the name follows.
    jobs+=("${id%%;*}")
}

submit() {
    mkdir -p "$work"
    # One of other parts, or of an earlier state of these.
    rm -f "$work/whole.glanz"
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
announced=
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
    limit=$(scontrol show config | sed -n 's/^MaxArraySize *= *//p')
    [ "$parts" -lt "${limit:-1001}" ] || fail "an array of this cluster has at most $((${limit:-1001} - 1)) tasks (MaxArraySize)"
    [[ $glanz != */* ]] || glanz=$(realpath "$glanz")
    export GLANZ=$glanz
    scene=$(realpath "$scene") output=$(realpath -m "$output") work=$(realpath -m "$work")
fi
$action "$@"
