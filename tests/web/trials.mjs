/* The tool tries fixes out and withdraws those that leave their finding, with the reason; the package only looks, and its commands begin with npx. leaveOutTrials(ours, theirs) takes what that changes out of both reports of one file. */
const REASON = /; (no fix|a fix leaves \d+ of \d+): .*$/s;

export function leaveOutTrials(ours, theirs) {
  (theirs.findings ?? []).forEach((finding, i) => {
    if (finding.command) finding.command = finding.command.replace(/^norma /, "npx norma-mesh ");
    const message = finding.message.replace(REASON, "");
    if (message === finding.message) return;
    finding.message = message;
    for (const side of [finding, ours.findings?.[i]]) if (side) for (const key of ["fix", "command"]) delete side[key];
  });
}
