# The filled-in study, for the jobs to read. Rules take it as ancient(): what concerns them stands in their params.
rule configure:
    output:
        STUDY_FILE,
    log:
        f"{LOGS}/configure.log",
    localrule: True
    params:
        study=SETTINGS,
    script:
        "../scripts/configure.py"
