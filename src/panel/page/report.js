// One file for a colleague: curves, events and telegrams of a station, with the samples and the capture inside. It opens
// without the emulator and without a network.
import { fileOf, lineOf, nameOf } from "./api.js";
import { saveText } from "./settings.js";

const WIDTH = 960;
const LANE = 130;
const EDGE = 70;
const COLORS = ["#0b6bcb", "#b35c00", "#2e7d32", "#444444"];
/** Octets that are turned into text at once. */
const PART = 0x4000;
/** Telegrams in the report at most; the capture has more. */
const MOST = 2000;

/** Text as it stands in a document. */
function plain(text) {
  return String(text).replace(/[&<>"]/g, (sign) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[sign]);
}

/** A file as an address that holds it; null: it is not to be had. */
async function inside(address) {
  try {
    const response = await fetch(address);
    if (!response.ok) return null;
    const octets = new Uint8Array(await response.arrayBuffer());
    const parts = [];
    for (let at = 0; at < octets.length; at += PART) parts.push(String.fromCharCode(...octets.subarray(at, at + PART)));
    return `data:application/octet-stream;base64,${btoa(parts.join(""))}`;
  } catch {
    return null;
  }
}

/** The curves as a picture, a lane for each value. */
function drawn({ left, right, lanes, samples, marks }) {
  const x = (time) => EDGE + ((time - left) / (right - left || 1)) * (WIDTH - EDGE - 10);
  const parts = lanes.map(({ key, name, unit, setpoints }, place) => {
    const top = place * LANE + 24;
    const bottom = top + LANE - 44;
    const known = (values) => [key, ...setpoints].map((one) => values[one]).filter((value) => typeof value === "number");
    const all = samples.flatMap(({ values }) => known(values));
    const low = all.reduce((a, b) => Math.min(a, b), Infinity);
    const high = all.reduce((a, b) => Math.max(a, b), -Infinity);
    if (all.length === 0) return "";
    const y = (value) => bottom - ((value - low) / (high - low || 1)) * (bottom - top);
    const points = (one) => samples.filter(({ values }) => typeof values[one] === "number").map(({ time_s, values }) => `${x(time_s).toFixed(1)},${y(values[one]).toFixed(1)}`);
    const color = COLORS[place % COLORS.length];
    const targets = setpoints.map((one) => `<polyline points="${points(one).join(" ")}" fill="none" stroke="#888" stroke-dasharray="5 4"/>`);
    return `<text x="${EDGE}" y="${top - 8}">${plain(unit ? `${name}, ${unit}` : name)}</text>
<text x="${EDGE - 6}" y="${top + 4}" text-anchor="end">${plain(Number(high.toPrecision(6)))}</text><text x="${EDGE - 6}" y="${bottom + 4}" text-anchor="end">${plain(Number(low.toPrecision(6)))}</text>
<rect x="${EDGE}" y="${top}" width="${WIDTH - EDGE - 10}" height="${bottom - top}" fill="none" stroke="#ccc"/>
${targets.join("")}<polyline points="${points(key).join(" ")}" fill="none" stroke="${color}" stroke-width="1.6"/>`;
  });
  const height = lanes.length * LANE + 24;
  const lines = marks.filter(({ time_s }) => time_s >= left && time_s <= right).map(({ time_s, text }) => `<line x1="${x(time_s)}" x2="${x(time_s)}" y1="16" y2="${height - 24}" stroke="#999" stroke-dasharray="1 4"><title>${plain(`${time_s.toFixed(3)} s: ${text}`)}</title></line>`);
  return `<svg viewBox="0 0 ${WIDTH} ${height}" role="img" aria-label="Curves">${parts.join("\n")}${lines.join("")}
<text x="${EDGE}" y="${height - 6}">${left.toFixed(2)} s</text><text x="${WIDTH - 10}" y="${height - 6}" text-anchor="end">${right.toFixed(2)} s</text></svg>`;
}

function table(title, lines) {
  const rows = lines.map(({ time_s, kind, text }) => `<tr><td>${time_s === null ? "" : time_s.toFixed(3)}</td><td>${plain(kind)}</td><td>${plain(text)}</td></tr>`);
  const none = lines.length === 0 ? "<p>none</p>" : "";
  return `<h2>${title}</h2>${none}<table><thead><tr><th>Time, s</th><th>Kind</th><th>What</th></tr></thead><tbody>${rows.join("\n")}</tbody></table>`;
}

/** Saves a report of what is shown now. */
export async function saveReport({ station, state, about, picture, events, telegrams, csv }) {
  const files = await Promise.all([
    ["Samples as CSV", `station-${station.address}.csv`, inside(csv)],
    ["Telegrams for Wireshark (pcapng)", `${station.line}.pcapng`, telegrams.length === 0 ? null : inside(fileOf(`${lineOf(station.line)}/capture.pcapng`))],
  ].map(async ([name, file, address]) => ({ name, file, address: await address })));
  const links = files.filter(({ address }) => address !== null).map(({ name, file, address }) => `<a download="${plain(file)}" href="${address}">${name}</a>`);
  const title = `Station ${nameOf(station, 2)}`;
  const document_ = `<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>${plain(title)}</title>
<style>body{font:14px/1.45 system-ui,sans-serif;margin:2em auto;max-width:1000px;padding:0 1em}svg{width:100%}svg text{font:11px system-ui}table{border-collapse:collapse;width:100%}td,th{text-align:left;padding:2px 8px;border-bottom:1px solid #ddd;vertical-align:top;overflow-wrap:anywhere}td:first-child{white-space:nowrap}</style></head>
<body><h1>${plain(title)}</h1><p>${plain(about)}. State: ${plain(state)}. Saved ${plain(new Date().toISOString())}.</p>
<p>${links.join(" · ")}</p>
${picture.lanes.length === 0 ? "" : `<h2>Curves</h2>${drawn(picture)}`}
${table("Events", events)}
${table("Telegrams", telegrams.slice(-MOST))}
</body></html>`;
  saveText(`station-${station.address}.html`, document_, "text/html");
}
