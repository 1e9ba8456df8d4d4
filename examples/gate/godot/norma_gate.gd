# Godot 3: choose this file as "Custom Script" of a scene in the Import dock. Each time Godot imports
# the scene, its file is checked; errors are shown in the editor, and the import fails.
tool
extends EditorScenePostImport

const PROFILE = "render"

static func check(path):
    var output = []
    var tool_path = OS.get_environment("NORMA") if OS.has_environment("NORMA") else "norma"
    var status = OS.execute(tool_path, ["check", "--format", "json", "--profile", PROFILE, "--", path], true, output)
    var parsed = JSON.parse(PoolStringArray(output).join(""))
    if parsed.error != OK:
        return {"accepted": false, "reasons": ["norma check ended with status %d" % status]}
    var reasons = []
    for file in parsed.result["files"]:
        for finding in file["findings"]:
            if finding["severity"] != "info":
                reasons.append("%s %s: %s Usual cause: %s" % [finding["severity"], finding["rule"], finding["message"], finding["cause"]])
    return {"accepted": status == 0, "reasons": reasons}

func post_import(scene):
    var verdict = check(ProjectSettings.globalize_path(get_source_file()))
    for reason in verdict["reasons"]:
        if verdict["accepted"]:
            push_warning("Norma: " + reason)
        else:
            push_error("Norma: " + reason)
    return scene if verdict["accepted"] else null
