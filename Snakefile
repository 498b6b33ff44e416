# From overhead footage to coefficients: one rule a stage, in reading order.
#
#   snakemake --cores all                                    the demo study, rendered first
#   snakemake --cores all --config study=PATH results=DIR    any study
#   snakemake --cores all challenge                          studies whose truth is concealed
#
# Values and their meaning: config/default.yaml, config/schema.yaml. Each rule calls the function
# of its name in pipeline/stages/. A bad trial writes why into status/ID.json and stops only itself;
# the rule `outcome` ends the run with a word on each of them when all else is done.

from pathlib import Path

from pipeline.workflow import begin, follow, shell_prefix, without_rate_limit


configfile: Path(workflow.basedir) / "config/default.yaml"


plan = begin(workflow, config, Path(workflow.basedir) / "config/schema.yaml")
R = plan.results
LOGS, TIMES = R / "logs", R / "benchmarks"
AT = plan.options
ENV = "config/environment.yaml"
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
        conda: ENV
        log: LOGS / "demo/{trial}.log"
        benchmark: TIMES / "demo/{trial}.tsv"
        params: at=AT, code=plan.code("demo"),
        resources: mem_mb=900, runtime=20,
        shell: "python3 -m pipeline stage demo {params.at} --trial {wildcards.trial} --threads {threads} &> {log:q}"


rule keypoints:
    input: plan.sources,
    output: R / "status/keypoints/{trial}.json",
    conda: ENV
    log: LOGS / "keypoints/{trial}.log"
    benchmark: TIMES / "keypoints/{trial}.tsv"
    params: at=AT, code=plan.code("keypoints"), settings=plan.detection,
    resources: mem_mb=900, runtime=60,
    shell: "python3 -m pipeline stage keypoints {params.at} --trial {wildcards.trial} --threads {threads} &> {log:q}"


rule geometry:
    input: expand(rules.keypoints.output, trial=plan.trials),
    output: R / "geometry.json",
    conda: ENV
    log: LOGS / "geometry.log"
    benchmark: TIMES / "geometry.tsv"
    params: at=AT, code=plan.code("geometry"), settings=plan.distances(),
    resources: mem_mb=900, runtime=20,
    shell: "python3 -m pipeline stage geometry {params.at} &> {log:q}"


rule tracks:
    input: rules.keypoints.output, plan.motor, plan.depth(),
    output: R / "status/{trial}.json",
    conda: ENV
    log: LOGS / "tracks/{trial}.log"
    benchmark: TIMES / "tracks/{trial}.tsv"
    params: at=AT, code=plan.code("tracks"), settings=plan.motion,
    resources: mem_mb=600, runtime=20,
    shell: "python3 -m pipeline stage tracks {params.at} --trial {wildcards.trial} &> {log:q}"


rule steady:
    input: expand(rules.tracks.output, trial=plan.trials),
    output: report(R / "steady.csv", "config/captions/steady.rst", "Tables"),
    conda: ENV
    log: LOGS / "steady.log"
    benchmark: TIMES / "steady.tsv"
    params: at=AT, code=plan.code("steady"),
    resources: mem_mb=400, runtime=5,
    shell: "python3 -m pipeline stage steady {params.at} &> {log:q}"


rule tuning:
    input: rules.steady.output,
    output:
        R / "coefficients.json",
        report(R / "table1.csv", "config/captions/table1.rst", "Tables"),
        report(R / "table2.csv", "config/captions/table2.rst", "Tables"),
    conda: ENV
    log: LOGS / "tuning.log"
    benchmark: TIMES / "tuning.tsv"
    params: at=AT, code=plan.code("tuning"), settings=plan.fit(),
    threads: 1  # takes what cores are idle: the other fit may run beside it
    resources: mem_mb=plan.memory_mb(800, 1), runtime=60,
    shell: "python3 -m pipeline stage tuning {params.at} &> {log:q}"


rule mismatch:
    input: rules.steady.output, rules.geometry.output,
    output: R / "mismatch.json", R / "mismatch_detail.json",
    conda: ENV
    log: LOGS / "mismatch.log"
    benchmark: TIMES / "mismatch.tsv"
    params: at=AT, code=plan.code("mismatch"), settings=plan.fit(),
    threads: 1  # takes what cores are idle: the other fit may run beside it
    resources: mem_mb=plan.memory_mb(900, 3), runtime=120,
    shell: "python3 -m pipeline stage mismatch {params.at} &> {log:q}"


rule figure:
    input: rules.tuning.output, rules.mismatch.output, plan.drawn_from,
    output:
        report(R / "figures/{figure}.png", "config/captions/figure.rst", "Figures"),
        R / "figures/{figure}.pdf",
    conda: ENV
    log: LOGS / "figures/{figure}.log"
    benchmark: TIMES / "figures/{figure}.tsv"
    params: at=AT, code=plan.figure_code, words=plan.figure_words,
    resources: mem_mb=800, runtime=10,
    shell: "python3 -m pipeline stage figure {params.at} --figure {wildcards.figure} &> {log:q}"


rule overlay:
    input: R / "status/{trial}.json", rules.tuning.output, rules.mismatch.output, plan.sources,
    output: R / "status/overlays/{trial}.json",
    conda: ENV
    log: LOGS / "overlay/{trial}.log"
    benchmark: TIMES / "overlay/{trial}.tsv"
    params: at=AT, code=plan.code("overlay"), settings=plan.motion,
    resources: mem_mb=800, runtime=20,
    shell: "python3 -m pipeline stage overlay {params.at} --trial {wildcards.trial} --threads {threads} &> {log:q}"


rule report:
    input: rules.tuning.output, rules.mismatch.output, plan.figures(), plan.overlays(), plan.seal(),
    output: report(R / "report.html", "config/captions/page.rst", "The page"),
    conda: ENV
    log: LOGS / "report.log"
    benchmark: TIMES / "report.tsv"
    params: at=AT, code=plan.code("report"),
    resources: mem_mb=800, runtime=10,
    shell: "python3 -m pipeline stage report {params.at} &> {log:q}"


rule outcome:
    input: plan.goals(),
    output: R / "outcome.json",
    conda: ENV
    log: LOGS / "outcome.log"
    params: at=AT, code=plan.code("outcome"),
    shell: "python3 -m pipeline stage outcome {params.at} &> {log:q}"


rule challenge:
    output: R / "challenge/score.json", R / "challenge/score.txt",
    conda: ENV
    log: LOGS / "challenge.log"
    benchmark: TIMES / "challenge.tsv"
    params: at=AT, code=plan.code("challenge"),
    threads: 2
    resources: mem_mb=3000, runtime=240,
    shell: "python3 -m pipeline stage challenge {params.at} --threads {threads} &> {log:q}"


onstart:
    without_rate_limit(workflow)


onsuccess:
    progress.farewell()


onerror:
    progress.farewell()
