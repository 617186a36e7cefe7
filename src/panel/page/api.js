// The HTTP API of the emulator: requests, and where a station is.
import { translationFor } from "./translation.js";

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

/** What makes stations of what the server tells; undefined before that is known, null if it needs none. */
let translation;
/** Whether another program may answer by now. */
let stale = false;

/**
 * Asks the server for something of lines and stations; the body and the answer are JSON. It is on its way when this
 * returns, if it is known how the server speaks: of a page that goes nothing runs later.
 */
export function request(method, path, body) {
  const send = () => (translation === null ? ask(method, path, body) : translation.request(method, path, body));
  return translation === undefined ? connect().then(send) : send();
}

/** Learns how the server speaks, if that is not known, or may be no more. */
export async function connect() {
  if (translation !== undefined && !stale) return;
  translation = await translationFor(ask);
  stale = false;
}

/** Another program may answer from now on. Until that is known, nothing waits for it. */
export function disconnect() {
  stale = true;
}

/** The address of the stream of what is wanted. */
export function eventsAddress(wanted) {
  const { station, kinds, interval_milliseconds } = wanted;
  const of = station === null ? {} : { line: station.line, address: station.address };
  const query = translation ? translation.query(wanted) : { kinds: kinds.join(","), interval_milliseconds, ...of };
  return `${ROOT}/events?${new URLSearchParams(query)}`;
}

/** An event of the stream: its name, and what it tells. */
export function eventOf(name, data) {
  return translation ? translation.event(name, data) : [name, data];
}

/** Where a file is to be had; null if the server has none. */
export function fileOf(path) {
  const file = translation ? translation.file(path) : path;
  return file === null ? null : ROOT + file;
}

/** As it goes over the line. A server that is frozen reaches nobody either. */
async function ask(method, path, body) {
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
  return answer;
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
