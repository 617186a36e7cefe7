// What the routes of each bus tell, as stations: each station with the lists of its description.
//
// Everything that depends on which kind of device there is stands in the three files of the translation. A server that
// speaks of lines and stations itself needs none.
import { Can } from "./translation_can.js";
import { Profibus } from "./translation_profibus.js";

/** The translation for a server, by the description of its API; null if it needs none. */
export async function translationFor(ask) {
  const { paths } = await ask("GET", "/openapi.json");
  if ("/api/v1/lines" in paths) return null;
  return "/api/v1/drives/{address}/objects" in paths ? new Can(ask) : new Profibus(ask);
}
