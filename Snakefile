# From overhead footage to coefficients: one rule a stage, in reading order.
#
#   snakemake --cores all                                    the demo study, rendered first
#   snakemake --cores all --config study=PATH results=DIR    any study
#
# Values and their meaning: config/default.yaml, config/schema.yaml. Each rule calls the function
# of its name in pipeline/stages/. A bad trial writes why into status/ID.json and stops only itself;
# the rule `outcome` ends the run with a word on each of them when all else is done.

from pathlib import Path

from pipeline.workflow import begin, follow, shell_prefix


configfile: Path(workflow.basedir) / "config/default.yaml"


conda: "config/environment.yaml"


plan = begin(workflow, config, Path(workflow.basedir) / "config/schema.yaml")
R = plan.results
LOGS, TIMES = R / "logs", R / "benchmarks"
STAGE = f"python3 -m pipeline stage --study {str(plan.folder)!r} --results {str(R)!r}"
progress = follow(workflow, R / "report.html")
shell.prefix(shell_prefix(workflow))


wildcard_constraints:
    trial=r"[A-Za-z0-9_-]+",
    figure=r"[a-z0-9_]+",


localrules:
    all,
    outcome,


rule all:
    input:
        plan.goals(),
        R / "outcome.json",


if plan.is_demo:

    rule demo:
        output:
            video=plan.folder / "videos/{trial}.mp4",
            motor=plan.folder / "motor/{trial}.csv",
        log: LOGS / "demo/{trial}.log",
        benchmark: TIMES / "demo/{trial}.tsv"
        params: code=plan.code("demo"),
        resources: mem_mb=900, runtime=20,
        shell: "{STAGE} --trial {wildcards.trial} --threads {threads} demo &> {log:q}"


rule keypoints:
    input: plan.sources,
    output: R / "status/keypoints/{trial}.json",
    log: LOGS / "keypoints/{trial}.log",
    benchmark: TIMES / "keypoints/{trial}.tsv"
    params: code=plan.code("keypoints"), settings=plan.detection,
    resources: mem_mb=900, runtime=60,
    shell: "{STAGE} --trial {wildcards.trial} --threads {threads} keypoints &> {log:q}"


rule tracks:
    input: rules.keypoints.output, plan.motor,
    output: R / "status/{trial}.json",
    log: LOGS / "tracks/{trial}.log",
    benchmark: TIMES / "tracks/{trial}.tsv"
    params: code=plan.code("tracks"), settings=plan.motion,
    resources: mem_mb=600, runtime=20,
    shell: "{STAGE} --trial {wildcards.trial} tracks &> {log:q}"


rule steady:
    input: expand(rules.tracks.output, trial=plan.trials),
    output: R / "steady.csv",
    log: LOGS / "steady.log",
    benchmark: TIMES / "steady.tsv"
    params: code=plan.code("steady"),
    resources: mem_mb=400, runtime=5,
    shell: "{STAGE} steady &> {log:q}"


rule outcome:
    input: plan.goals(),
    output: R / "outcome.json",
    log: LOGS / "outcome.log",
    params: code=plan.code("outcome"),
    shell: "{STAGE} outcome &> {log:q}"


onsuccess:
    progress.farewell()


onerror:
    progress.farewell()
