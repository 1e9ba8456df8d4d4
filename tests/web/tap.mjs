/* Checks as TAP lines, as tests/support/tap.sh has them. */
let number = 0, failed = 0;

export function check(name, holds, detail) {
  number++;
  if (!holds) failed++;
  console.log(`${holds ? "ok" : "not ok"} ${number} - ${name}`);
  if (!holds && detail !== undefined) console.log(String(detail).split("\n").slice(0, 40).map((line) => `# ${line}`).join("\n"));
  return holds;
}

export function skip(name) { console.log(`ok ${++number} # SKIP ${name}`); }

/* The tool's report of a file, with the commands that the package offers: they begin with npx. */
export function asNpx(file) {
  for (const finding of file.findings ?? []) if (finding.command) finding.command = finding.command.replace(/^norma /, "npx norma-mesh ");
  return file;
}

/* NORMA_ONLY: a regular expression; cases with other names are left out, for whoever works on one. */
export async function attempt(name, work) {
  if (process.env.NORMA_ONLY && !new RegExp(process.env.NORMA_ONLY).test(name)) return true;
  try {
    await work();
    return check(name, true);
  } catch (error) {
    return check(name, false, error?.stack ?? error);
  }
}

export function finish() {
  console.log(`1..${number}`);
  process.exitCode = failed || !number ? 1 : 0;
}
