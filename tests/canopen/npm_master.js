// npm's canopen (node-canopen) moves a drive from an EDS over slcan on TCP:
//
//   npm_master.js HOST:PORT NODE
//
// NMT, SDO, and a TPDO that is heard. Exit status 0 if every step passed, else a line that begins with FAIL.
const net = require("net");
const { Device, DataType } = require("canopen");

const [place, text] = process.argv.slice(2);
const [host, port] = place.split(":");
const NODE = Number(text);
const heard = [];

function fail(what) {
    console.log(`FAIL npm canopen: ${what}`);
    process.exit(1);
}

function expect(condition, what) {
    if (!condition) fail(what);
    console.log(`ok npm canopen: ${what}`);
}

const device = new Device({ id: 100 });
const line = net.connect(Number(port), host);
let rest = "";
line.on("data", (octets) => {
    const lines = (rest + octets.toString("latin1")).split(/[\r\x07]/);
    rest = lines.pop();
    for (const frame of lines.filter((frame) => frame.startsWith("t"))) {
        const id = parseInt(frame.slice(1, 4), 16);
        const data = Buffer.from(frame.slice(5, 5 + 2 * Number(frame[4])), "hex");
        heard.push(id);
        device.receive({ id, data });
    }
});
line.on("error", (error) => fail(error.message));
device.addListener("message", ({ id, data }) => {
    const hex = (number, digits) => number.toString(16).toUpperCase().padStart(digits, "0");
    line.write(`t${hex(id, 3)}${data.length}${[...data].map((octet) => hex(octet, 2)).join("")}\r`);
});

const pause = (millis) => new Promise((resolve) => setTimeout(resolve, millis));
const read = (index, dataType, subIndex = 0) =>
    device.sdo.upload({ serverId: NODE, index, subIndex, dataType, timeout: 2000 });
const write = (index, dataType, data, subIndex = 0) =>
    device.sdo.download({ serverId: NODE, index, subIndex, dataType, data, timeout: 2000 });

async function until(what, condition) {
    for (let tries = 0; tries < 4000; tries += 1) {
        if (await condition()) return expect(true, what);
        await pause(5);
    }
    fail(`${what}: not within 20 s`);
}

async function main() {
    line.write("S6\rO\r");
    await pause(100);
    device.eds.addSdoClientParameter(NODE, 0x600 + NODE, 0x580 + NODE);
    device.start();
    expect(((await read(0x1000, DataType.UNSIGNED32)) & 0xffff) === 402, "1000h says CiA 402");
    device.nmt.startNode(NODE);
    await write(0x6060, DataType.INTEGER8, 1);
    const status = () => read(0x6041, DataType.UNSIGNED16);
    const steps = [[6, 0x21], [7, 0x23], [15, 0x27]];
    for (const [word, state] of steps) {
        await write(0x6040, DataType.UNSIGNED16, word);
        await until(`6040h = ${word}`, async () => ((await status()) & 0x6f) === state);
    }
    const before = await read(0x6064, DataType.INTEGER32);
    const target = before + 1000;
    await write(0x607a, DataType.INTEGER32, target);
    await write(0x6040, DataType.UNSIGNED16, 0x1f);
    await until("set-point acknowledged", async () => (await status()) & 0x1000);
    await write(0x6040, DataType.UNSIGNED16, 0x0f);
    await until("target reached", async () => ((await status()) & 0x1400) === 0x400);
    const position = await read(0x6064, DataType.INTEGER32);
    expect(Math.abs(position - target) <= 100, `at ${position}, asked for ${target}`);
    expect(heard.includes(0x580 + NODE), "answers on 580h");
    await write(0x6040, DataType.UNSIGNED16, 0);
    process.exit(0);
}

main().catch((error) => fail(String(error)));
