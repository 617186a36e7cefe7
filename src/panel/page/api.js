// The HTTP API of the emulator: requests, and the stream of what happens.

const ROOT = "/api/v1";
const RETRY_MS = 1000;
/** Nothing for so long, and the stream is taken for dead: the server says something at least this often. */
const SILENCE_MS = 20_000;

/** A request that was refused, or reached nobody. `message` is a sentence for a person. */
export class Refused extends Error {}

/** Asks the server; the body and the answer are JSON. */
export async function request(method, path, body) {
  let response;
  try {
    response = await fetch(ROOT + path, {
      method,
      headers: body === undefined ? {} : { "content-type": "application/json" },
      body: body === undefined ? undefined : JSON.stringify(body),
    });
  } catch {
    throw new Refused("the emulator does not answer");
  }
  const text = await response.text();
  let answer = null;
  try {
    answer = text === "" ? null : JSON.parse(text);
  } catch {
    throw new Refused(`not understood: ${text.slice(0, 200)}`);
  }
  if (!response.ok) throw new Refused(answer?.detail ?? `${response.status} ${response.statusText}`);
  return answer;
}
