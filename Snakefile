# From overhead footage to coefficients: one rule a stage, in reading order.
#
#   snakemake --cores all                                    the demo study, rendered first
#   snakemake --cores all --config study=PATH results=DIR    any study
#
# Values and their meaning: config/default.yaml, config/schema.yaml. Each rule calls the function
# of its name in pipeline/bluekoi/stages/. A bad trial writes why into status/ID.json and stops only itself;
# the rule `outcome` ends the run with a word on each of them when all else is done.

from pathlib import Path

from bluekoi.workflow.run_start import begin_run, shell_prefix, remove_job_rate_limit
from bluekoi.workflow.preload import start_fork_server
from bluekoi.workflow.progress import attach_progress


configfile: Path(workflow.basedir) / "config/default.yaml"


plan = begin_run(workflow, config, Path(workflow.basedir) / "config/schema.yaml")
R = plan.results
LOGS = R / "logs"
AT = plan.stage_options
ENV = "config/environment.yaml"
progress = attach_progress(workflow, R / "report.html")
shell.prefix(shell_prefix(workflow))


wildcard_constraints:
    trial=r"[A-Za-z0-9_-]+",
    batch=r"[0-9]+(-due)?",
    figure=r"[a-z0-9_]+",


localrules:
    all,
    outcome,


rule all:
    input:
        plan.targets(),
        R / "outcome.json",


if plan.is_demo:

    rule demo:
        output:
            video=plan.folder / "videos/{trial}.mp4",
            motor=plan.folder / "motor/{trial}.csv",
        conda: ENV
        log: LOGS / "demo/{trial}.log"
        params: at=AT, code=plan.code_fingerprint("demo"),
        resources: mem_mb=900, runtime=20,
        shell: "python3 -P -m bluekoi stage demo {params.at} --trial {wildcards.trial} --threads {threads} &> {log:q}"


rule keypoints:
    input: plan.demo_recording_files,
    output: R / "status/batches/keypoints-{batch}",
    conda: ENV
    log: LOGS / "keypoints/{batch}.log"
    params: at=AT, code=plan.code_fingerprint("keypoints"), trials=plan.batch_trial_options("keypoints"),
    resources: mem_mb=900, runtime=60,
    shell: "python3 -P -m bluekoi stage keypoints {params.at} --code {params.code} {params.trials} --threads {threads} --done {output:q} &> {log:q}"


rule keypoint_errors:
    input: plan.batch_marker_files("keypoints"),
    output: R / "status/stages/keypoint_errors.json",
    conda: ENV
    log: LOGS / "keypoint_errors.log"
    params: at=AT, code=plan.code_fingerprint("keypoint_errors"), settings=plan.geometry_fingerprint(),
    resources: mem_mb=900, runtime=20,
    shell: "python3 -P -m bluekoi stage keypoint_errors {params.at} &> {log:q}"


rule geometry:
    input: plan.batch_marker_files("keypoints"), plan.keypoint_errors_file(),
    output: R / "geometry.json",
    conda: ENV
    log: LOGS / "geometry.log"
    params: at=AT, code=plan.code_fingerprint("geometry"), settings=plan.geometry_fingerprint(),
    resources: mem_mb=900, runtime=20,
    shell: "python3 -P -m bluekoi stage geometry {params.at} &> {log:q}"


rule tracks:
    input: plan.keypoints_marker_file, plan.keypoint_errors_file(), plan.keypoint_depth_file(),
    output: R / "status/batches/tracks-{batch}",
    conda: ENV
    log: LOGS / "tracks/{batch}.log"
    params: at=AT, code=plan.code_fingerprint("tracks"), trials=plan.batch_trial_options("tracks"),
    resources: mem_mb=600, runtime=20,
    shell: "python3 -P -m bluekoi stage tracks {params.at} --code {params.code} {params.trials} --done {output:q} &> {log:q}"


rule steady:
    input: plan.batch_marker_files("tracks"),
    output: report(R / "steady.csv", "config/captions/steady.rst", "Tables"),
    conda: ENV
    log: LOGS / "steady.log"
    params: at=AT, code=plan.code_fingerprint("steady"), trials=plan.all_trial_ids,
    resources: mem_mb=400, runtime=5,
    shell: "python3 -P -m bluekoi stage steady {params.at} &> {log:q}"


rule tuning:
    input: rules.steady.output, plan.keypoint_errors_file(),
    output:
        R / "coefficients.json",
        report(R / "table1.csv", "config/captions/table1.rst", "Tables"),
        report(R / "table2.csv", "config/captions/table2.rst", "Tables"),
    conda: ENV
    log: LOGS / "tuning.log"
    params: at=AT, code=plan.code_fingerprint("tuning"), settings=plan.fit_fingerprint(),
    threads: 1  # takes what cores are idle: the other fit may run beside it
    resources: mem_mb=plan.memory_mb(800, 1), runtime=60,
    shell: "python3 -P -m bluekoi stage tuning {params.at} &> {log:q}"


rule mismatch:
    input: rules.steady.output, rules.geometry.output,
    output: R / "mismatch.json", R / "mismatch_detail.json",
    conda: ENV
    log: LOGS / "mismatch.log"
    params: at=AT, code=plan.code_fingerprint("mismatch"), settings=plan.fit_fingerprint(),
    threads: 1  # takes what cores are idle: the other fit may run beside it
    resources: mem_mb=plan.memory_mb(900, 3), runtime=120,
    shell: "python3 -P -m bluekoi stage mismatch {params.at} &> {log:q}"


rule figure:
    input: rules.tuning.output, rules.mismatch.output, plan.extra_figure_inputs,
    output:
        report(R / "figures/{figure}.png", "config/captions/figure.rst", "Figures"),
        R / "figures/{figure}.pdf",
        R / "figures/{figure}.csv",
    conda: ENV
    log: LOGS / "figures/{figure}.log"
    params: at=AT, code=plan.figure_fingerprint, words=plan.figure_title_and_caption,
    resources: mem_mb=800, runtime=10,
    shell: "python3 -P -m bluekoi stage figure {params.at} --figure {wildcards.figure} &> {log:q}"


rule overlay:
    input: plan.tracks_marker_file, rules.tuning.output, rules.mismatch.output, plan.demo_recording_files,
    output: R / "status/batches/overlay-{batch}",
    conda: ENV
    log: LOGS / "overlay/{batch}.log"
    params: at=AT, code=plan.code_fingerprint("overlay"), trials=plan.batch_trial_options("overlay"),
    resources: mem_mb=800, runtime=20,
    shell: "python3 -P -m bluekoi stage overlay {params.at} --code {params.code} {params.trials} --threads {threads} --done {output:q} &> {log:q}"


rule report:
    input: rules.tuning.output, rules.mismatch.output, plan.figure_png_files(), plan.batch_marker_files("overlay"),
    output: report(R / "report.html", "config/captions/page.rst", "The page"),
    conda: ENV
    log: LOGS / "report.log"
    params: at=AT, code=plan.code_fingerprint("report"),
    resources: mem_mb=800, runtime=10,
    shell: "python3 -P -m bluekoi stage report {params.at} &> {log:q}"


rule outcome:
    input: plan.targets(),
    output: R / "outcome.json",
    conda: ENV
    log: LOGS / "outcome.log"
    params: at=AT, code=plan.code_fingerprint("outcome"),
    shell: "python3 -P -m bluekoi stage outcome {params.at} &> {log:q}"


onstart:
    remove_job_rate_limit(workflow)
    progress.preloaded = start_fork_server(workflow, plan)


onsuccess:
    progress.print_final_summary()


onerror:
    progress.print_final_summary()
