// A node of npm's canopen (node-canopen) behind the adapter of `profidrive judge --node`:
//
//   judged_node.js LINK NODE EDS
//
// The node's own data sheet is written to EDS first. LINK is the terminal of the judge; with - that is all. The program
// ends with the judge.
const fs = require("fs");
const { AccessType, DataType, Device, Eds, ObjectType } = require("canopen");

const [link, text, sheet] = process.argv.slice(2);
const NODE = Number(text);

const eds = new Eds({ vendorName: "profidrive", productName: "node of node-canopen", baudRates: [500000] });
const saveDefault = { saveDefault: true };
const value = (index, parameterName, dataType, accessType, defaultValue) =>
    eds.addEntry(index, { parameterName, objectType: ObjectType.VAR, dataType, accessType, defaultValue, pdoMapping: true });
eds.setIdentity({ vendorId: 0x195, productCode: 11, revisionNumber: 1, serialNumber: 7 }, saveDefault);
eds.setSyncCobId(0x80, saveDefault);
eds.setEmcyCobId(0x80 + NODE, saveDefault);
eds.setHeartbeatProducerTime(0, saveDefault);
eds.setErrorHistoryLength(4);
eds.addSdoServerParameter(0, 0x580 + NODE, 0x600 + NODE, saveDefault);
const level = value(0x2000, "Level", DataType.UNSIGNED16, AccessType.READ_WRITE, 100);
const output = value(0x2001, "Output", DataType.UNSIGNED16, AccessType.READ_WRITE, 0);
value(0x2002, "Name", DataType.VISIBLE_STRING, AccessType.READ_ONLY, "a text of its own");
const pdo = { transmissionType: 1, inhibitTime: 0, eventTime: 0, syncStart: 0 };
eds.addTransmitPdo({ ...pdo, cobId: 0x180 + NODE, dataObjects: [level] }, saveDefault);
eds.addReceivePdo({ ...pdo, cobId: 0x200 + NODE, dataObjects: [output] }, saveDefault);
eds.save(sheet);
if (link === "-") process.exit(0);

const device = new Device({ eds, id: NODE });
const line = fs.openSync(link, "r+");
const input = fs.createReadStream(null, { fd: line, autoClose: false });
let rest = "";
input.on("data", (octets) => {
    const lines = (rest + octets.toString("latin1")).split(/[\r\x07]/);
    rest = lines.pop();
    for (const frame of lines.filter((frame) => frame.startsWith("t"))) {
        const id = parseInt(frame.slice(1, 4), 16);
        const data = Buffer.from(frame.slice(5, 5 + 2 * Number(frame[4])), "hex");
        // It throws at frames that are too short; a program that does not catch that ends.
        try {
            device.receive({ id, data, len: data.length });
        } catch (error) {
            console.error(`${frame}: ${error.message}`);
        }
    }
});
input.on("error", () => process.exit(0));
input.on("end", () => process.exit(0));
device.addListener("message", ({ id, data }) => {
    const hex = (number, digits) => number.toString(16).toUpperCase().padStart(digits, "0");
    fs.writeSync(line, `t${hex(id, 3)}${data.length}${[...data].map((octet) => hex(octet, 2)).join("")}\r`);
});
fs.writeSync(line, "C\rS6\rO\r");
device.start();
setInterval(() => fs.existsSync(link) || process.exit(0), 200);
