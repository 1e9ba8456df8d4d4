/* Waiting, for the tests in browsers. */
export const pause = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));

/* A function that waits until an expression holds in a page, and returns its value. */
export const waitFor = (evaluate) => async (expression, seconds = 100) => {
  for (const end = Date.now() + 1000 * seconds; Date.now() < end; await pause(30)) {
    const value = await evaluate(expression).catch(() => undefined);
    if (value) return value;
  }
  throw new Error(`waited ${seconds} s in vain for ${expression}`);
};
