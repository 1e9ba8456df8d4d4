"""ComfyUI: put this folder into custom_nodes. The node "Norma gate" takes the path of a mesh that another node wrote, and stops the workflow if `norma check` refuses it."""
import json
import os
import subprocess


class NormaGate:
    """Checks a mesh file; fixes it first, if asked to."""

    CATEGORY = "3d"
    FUNCTION = "check"
    RETURN_TYPES = ("STRING", "BOOLEAN", "STRING")
    RETURN_NAMES = ("path", "accepted", "report")
    OUTPUT_NODE = True

    @classmethod
    def INPUT_TYPES(cls):
        return {
            "required": {
                "path": ("STRING", {"default": ""}),
                "profile": (["generated", "render", "print"],),
                "fix": (["nothing", "safe", "unsafe"],),
                "stop": ("BOOLEAN", {"default": True}),
            }
        }

    @classmethod
    def IS_CHANGED(cls, path, **_):
        """A file that was written again is checked again."""
        return os.path.getmtime(path) if os.path.exists(path) else float("nan")

    def check(self, path, profile, fix, stop):
        command = [os.environ.get("NORMA", "norma"), "check", "--format", "json", "--profile", profile]
        if fix != "nothing":
            stem, ending = os.path.splitext(path)
            fixed = f"{stem}.fixed{ending}"
            command += ["--fix" if fix == "safe" else "--fix-unsafe", "-o", fixed]
        run = subprocess.run(command + ["--", path], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
        if run.returncode not in (0, 1) and not run.stdout:
            raise RuntimeError(f"Norma: {run.stderr.strip()}")
        findings = [f for file in json.loads(run.stdout)["files"] for f in file["findings"] if f["severity"] != "info"]
        report = "\n".join(f"{f['severity']} {f['rule']} {f['name']}: {f['message']}\n  Usual cause: {f['cause']}\n  Impact: {f['impact']}" for f in findings) or "No problems found"
        if run.returncode and stop:
            raise RuntimeError(f"Norma refuses {path}:\n{report}")
        return (path if fix == "nothing" or run.returncode > 1 else fixed, run.returncode == 0, report)


NODE_CLASS_MAPPINGS = {"NormaGate": NormaGate}
NODE_DISPLAY_NAME_MAPPINGS = {"NormaGate": "Norma gate"}
