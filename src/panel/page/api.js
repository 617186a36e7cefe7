// The HTTP API of the emulator: requests, and where a station is.

const ROOT = "/api/v1";
/** An answer comes within this, or none does. */
const ANSWER_MS = 5000;
export const NO_ANSWER = "the emulator does not answer";

/** A request that was refused, or reached nobody (`status` 0). `message` is a sentence for a person. */
export class Refused extends Error {
  constructor(message, status = 0) {
    super(message);
    this.status = status;
  }
}

/** The address of the stream of what is wanted: of a station, or of all when `station` is null. */
export function eventsAddress({ station, kinds, interval_milliseconds }) {
  const of = station === null ? {} : { line: station.line, address: station.address };
  return `${ROOT}/events?${new URLSearchParams({ kinds: kinds.join(","), interval_milliseconds, ...of })}`;
}

/** Where a file is to be had. */
export function fileOf(path) {
  return ROOT + path;
}

/**
 * Asks the server; the body and the answer are JSON. It is on its way when this returns: of a page that goes nothing runs
 * later. A server that is frozen reaches nobody either.
 */
export async function request(method, path, body) {
  let response;
  let text;
  try {
    response = await fetch(ROOT + path, {
      method,
      headers: body === undefined ? {} : { "content-type": "application/json" },
      body: body === undefined ? undefined : JSON.stringify(body),
      // The release of a key arrives even if the page goes at the same time.
      keepalive: body !== undefined,
      signal: AbortSignal.timeout(ANSWER_MS),
    });
    text = await response.text();
  } catch {
    throw new Refused(NO_ANSWER);
  }
  let answer = null;
  try {
    answer = text === "" ? null : JSON.parse(text);
  } catch {
    throw new Refused(`not understood: ${text.slice(0, 200)}`, response.status);
  }
  if (!response.ok) throw new Refused(answer?.detail ?? response.statusText, response.status);
  if (method !== "GET") for (const told of listeners) told({ method, path, body, answer });
  return answer;
}

/** Who is told what was asked to be changed, and was. */
const listeners = [];

/** `told({ method, path, body, answer })` is called for each change that the server has made. */
export function onRequest(told) {
  listeners.push(told);
}

/** The path of a line in the API. */
export function lineOf(line) {
  return `/lines/${encodeURIComponent(line)}`;
}

/** The path of a station in the API: of its line, and its address there. */
export function stationOf({ line, address }) {
  return `${lineOf(line)}/stations/${address}`;
}

/** Whether two are the same station. */
export function isSame(one, other) {
  return one?.line === other?.line && one?.address === other?.address;
}

/** The view of a station, as the address of the page has it. */
export function linkOf({ line, address }) {
  return `#station/${encodeURIComponent(line)}/${address}`;
}

/** A station in words: `5`, and its line where there are several. */
export function nameOf({ line, address }, lines) {
  return lines > 1 ? `${line}/${address}` : String(address);
}
