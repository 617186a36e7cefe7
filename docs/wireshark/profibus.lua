-- PROFIBUS for Wireshark and tshark: FDL telegrams, the services of DP-V0 and DP-V1, and the PPO of SIKO AG03 and AG03/1 drives.
--
-- Wireshark knows no link type 257 (PROFIBUS_DL) and shows such captures as octets. How to install this file, and
-- what to filter for, is in README.md beside it. Sources: EN 50170 parts 4 and 8 at second hand, the PROFIBUS manuals of
-- SIKO AG03 (firmware 3.00) and AG03/1 (firmware 1.00).
--
-- In this order: names of values, fields, what is remembered from packet to packet, PPO, DP services, FDL.

local fdl = Proto("profibus", "PROFIBUS")
local ppo = Proto("ppo", "PROFIDRIVE PPO")

------------------------------------------------------------------------------------------------- names of values

local START_DELIMITER = {
    [0x10] = "SD1, without data", [0x68] = "SD2, with data", [0xA2] = "SD3, with 8 octets of data",
    [0xDC] = "SD4, token", [0xE5] = "SC, short acknowledge",
}

local REQUEST = {
    [0x0] = "TE", [0x3] = "SDA_LOW", [0x4] = "SDN_LOW", [0x5] = "SDA_HIGH", [0x6] = "SDN_HIGH", [0x7] = "MSRD",
    [0x9] = "FDL_STATUS", [0xC] = "SRD_LOW", [0xD] = "SRD_HIGH", [0xE] = "IDENT", [0xF] = "LSAP_STATUS",
}

-- The requests that nobody answers.
local UNANSWERED = { [0x0] = true, [0x4] = true, [0x6] = true }

local STATUS = {
    [0x0] = "OK", [0x1] = "UE", [0x2] = "RR", [0x3] = "RS", [0x8] = "DL", [0x9] = "NR", [0xA] = "DH", [0xC] = "RDL",
    [0xD] = "RDH",
}

local STATUS_WORDS = {
    [0x0] = "positive", [0x1] = "user error", [0x2] = "no resource", [0x3] = "service not activated",
    [0x8] = "data", [0x9] = "no data", [0xA] = "data, a diagnosis waits",
    [0xC] = "data, request not taken", [0xD] = "data with high priority, request not taken",
}

local STATION_TYPE = {
    [0] = "slave", [1] = "master, not ready for the ring", [2] = "master, ready for the ring", [3] = "master, in the ring",
}

-- Configurations that have the PPO drawn below: 4 words PKW and 3 words PZD.
local PPO_CONFIGURATION = { ["F3F2"] = true, ["F6"] = true }
local PPO_LEN = 14

local JOB = {
    [0] = "no job", [1] = "read", [2] = "write word", [3] = "write double word", [4] = "read description of",
    [5] = "write description of", [6] = "read element of", [7] = "write word into array",
    [8] = "write double word into array", [9] = "read number of elements of",
}

local ANSWER = {
    [0] = "no answer", [1] = "word", [2] = "double word", [3] = "description", [4] = "word of array",
    [5] = "double word of array", [6] = "number of elements", [7] = "not executable", [8] = "no control rights",
}

local PKW_ERROR = {
    [0] = "no such parameter number", [1] = "value cannot be changed", [2] = "value outside the limits",
    [3] = "wrong sub-index", [4] = "not an array", [5] = "wrong data type", [6] = "value can only be reset",
    [7] = "description cannot be changed", [8] = "PPO write required in the information report is missing",
    [9] = "no description available", [10] = "wrong access group", [11] = "no control rights", [12] = "wrong password",
    [13] = "text cannot be read cyclically", [14] = "name cannot be read cyclically", [15] = "no text array",
    [16] = "PPO write is missing", [17] = "not possible in this operating state", [18] = "other error",
    [19] = "datum cannot be read cyclically",
}

-- The tables from here to the end mark are those of the crate (param::TABLE, device::bits, and the bits and SAPs of
-- dp). The test -- facts::the_dissector_has_the_tables_of_the_crate compares them, and writes them with WRITE_DISSECTOR=1.
-- Bits: { number, name, text, words for 1, words for 0 }.
local PNU = {
    [918] = "Profibus address",
    [930] = "Operating mode",
    [945] = "Fault buffer",
    [952] = "Number of faults",
    [961] = "Hardware version",
    [965] = "Software version",
    [970] = "Load parameter data record",
    [1000] = "Controller parameter P",
    [1001] = "Controller parameter I",
    [1002] = "Controller parameter D",
    [1003] = "a-Pos",
    [1004] = "v-Pos",
    [1005] = "a-Rot",
    [1007] = "a-Inch",
    [1008] = "v-Inch",
    [1009] = "Pos window",
    [1010] = "Gear numerator",
    [1011] = "Gear denominator",
    [1012] = "Spindle pitch",
    [1013] = "Sense of rotation",
    [1014] = "Pos type",
    [1016] = "Limit 1",
    [1017] = "Limit 2",
    [1018] = "Calibration value",
    [1019] = "Delta inch",
    [1020] = "System status word",
    [1021] = "Stop mode inch 2",
    [1022] = "Inpos mode",
    [1023] = "Loop length",
    [1027] = "Device temperature",
    [1029] = "Motor current",
    [1031] = "General status register",
    [1032] = "Torque deactivation",
    [1033] = "Serial number",
    [1034] = "Date of production",
    [1035] = "Offset inching 2",
    [1036] = "Position value",
    [1039] = "d-Pos",
    [1040] = "Supply voltage output stage",
    [1041] = "Supply voltage control",
    [1042] = "Battery voltage",
}
local DIAG_BITS_1 = {
    { 7, "master_lock", "Master_Lock" },
    { 6, "prm_fault", "Prm_Fault" },
    { 5, "invalid_slave_response", "Invalid_Slave_Response" },
    { 4, "not_supported", "Not_Supported" },
    { 3, "ext_diag", "Ext_Diag" },
    { 2, "cfg_fault", "Cfg_Fault" },
    { 1, "station_not_ready", "Station_Not_Ready" },
    { 0, "station_non_existent", "Station_Non_Existent" },
}
local DIAG_BITS_2 = {
    { 7, "deactivated", "Deactivated" },
    { 5, "sync_mode", "Sync_Mode" },
    { 4, "freeze_mode", "Freeze_Mode" },
    { 3, "wd_on", "WD_On" },
    { 2, "always_1", "always 1" },
    { 1, "stat_diag", "Stat_Diag" },
    { 0, "prm_req", "Prm_Req" },
}
local DIAG_BITS_3 = {
    { 7, "ext_diag_overflow", "Ext_Diag_Overflow" },
}
local SERVICE_OF_SAP = {
    [55] = "Set_Slave_Add",
    [56] = "RD_Inp",
    [57] = "RD_Outp",
    [58] = "Global_Control",
    [59] = "Get_Cfg",
    [60] = "Slave_Diag",
    [61] = "Set_Prm",
    [62] = "Chk_Cfg",
}
local V1_FUNCTION = {
    [72] = "Idle",
    [81] = "Data_Transport",
    [86] = "RM",
    [87] = "Initiate",
    [88] = "Abort",
    [92] = "Alarm_Ack",
    [94] = "Read",
    [95] = "Write",
}
local V1_ERROR = {
    [160] = "read error",
    [161] = "write error",
    [162] = "module failure",
    [168] = "version conflict",
    [169] = "feature not supported",
    [176] = "invalid index",
    [177] = "write length error",
    [178] = "invalid slot",
    [179] = "type conflict",
    [180] = "invalid area",
    [181] = "state conflict",
    [182] = "access denied",
    [183] = "invalid range",
    [184] = "invalid parameter",
    [185] = "invalid type",
    [192] = "read constraint conflict",
    [193] = "write constraint conflict",
    [194] = "resource busy",
    [195] = "resource unavailable",
}
local PARAMETER_ERROR = {
    [0] = "no such parameter",
    [1] = "not changeable",
    [2] = "outside of its limits",
    [3] = "no such sub-index",
    [4] = "no array",
    [5] = "wrong data type",
    [6] = "may only be set to 0",
    [7] = "its description cannot be changed",
    [9] = "no description",
    [11] = "no right to change it",
    [15] = "no texts",
    [16] = "may not be read",
    [17] = "not in this state of the drive",
    [20] = "a value that is not permitted",
    [21] = "the response is too long",
    [22] = "an address that is none",
    [23] = "a format that is none",
    [24] = "another number of values than of elements",
    [25] = "no such axis",
    [32] = "its text cannot be changed",
    [33] = "no such service",
    [35] = "too many requests at once",
}
local FORMAT = {
    [1] = "boolean",
    [2] = "integer of 8 bits",
    [3] = "integer of 16 bits",
    [4] = "integer of 32 bits",
    [5] = "unsigned of 8 bits",
    [6] = "unsigned of 16 bits",
    [7] = "unsigned of 32 bits",
    [8] = "floating point",
    [9] = "text",
    [10] = "octets",
    [12] = "time of day",
    [13] = "time difference",
    [33] = "normalised of 16 bits",
    [34] = "normalised of 32 bits",
    [35] = "bits",
    [36] = "nibbles",
    [64] = "no value",
    [65] = "octet",
    [66] = "word",
    [67] = "double word",
    [68] = "error",
}
local FORMAT_SIZE = {
    [1] = 1,
    [2] = 1,
    [3] = 2,
    [4] = 4,
    [5] = 1,
    [6] = 2,
    [7] = 4,
    [8] = 4,
    [9] = 1,
    [10] = 1,
    [12] = 6,
    [13] = 4,
    [33] = 2,
    [34] = 4,
    [35] = 2,
    [36] = 2,
    [64] = 0,
    [65] = 1,
    [66] = 2,
    [67] = 4,
    [68] = 2,
}
local PRM_BITS = {
    { 7, "lock_req", "Lock_Req" },
    { 6, "unlock_req", "Unlock_Req" },
    { 5, "sync_req", "Sync_Req" },
    { 4, "freeze_req", "Freeze_Req" },
    { 3, "wd_on", "WD_On" },
}
local CONTROL_BITS = {
    { 5, "sync", "Sync" },
    { 4, "unsync", "Unsync" },
    { 3, "freeze", "Freeze" },
    { 2, "unfreeze", "Unfreeze" },
    { 1, "clear_data", "Clear_Data" },
}
local IDENTIFIER_BITS = {
    { 7, "consistency", "consistency" },
    { 6, "unit", "unit" },
    { 5, "output", "output" },
    { 4, "input", "input" },
}
local SPECIAL_BITS = {
    { 7, "output_length", "output length" },
    { 6, "input_length", "input length" },
}
local COUNTS, LENGTHS, NOT_COMPARED = 16, 64, 15
local STW_BITS = {
    { 0, "on", "ON / OFF1", "ON", "OFF1" },
    { 1, "no_off2", "no OFF2", "no OFF2", "OFF2" },
    { 2, "off3", "OFF3, must be 0" },
    { 3, "enable_operation", "enable operation", "enable operation", "disable operation" },
    { 4, "no_stop", "stop (positioning)", "no stop", "stop" },
    { 5, "no_intermediate_stop", "intermediate stop (positioning)", "no intermediate stop", "intermediate stop" },
    { 6, "start", "positioning: activate travel job; velocity: enable target value" },
    { 7, "acknowledge", "acknowledge", "acknowledge", "acknowledge bit 0" },
    { 8, "inch1", "inching 1 (positioning)", "inching 1", "inching 1 off" },
    { 9, "inch2", "inching 2 (positioning)", "inching 2", "inching 2 off" },
    { 15, "inch2_negative", "direction of inching 2 (positioning)", "negative direction", "positive direction" },
}
local ZSW_BITS = {
    { 0, "ready_to_turn_on", "ready to turn on", "ready to turn on", "not ready to turn on" },
    { 1, "ready", "ready", "ready", "not ready" },
    { 2, "operation_enabled", "operation enabled", "enabled", "operation disabled" },
    { 3, "fault", "fault", "FAULT", "no fault" },
    { 4, "no_off2", "no OFF2", "no OFF2", "OFF2 given" },
    { 5, "no_off3", "no OFF3, always 1" },
    { 6, "turn_on_disabled", "turn-on disabled", "turn-on disabled", "turn-on not disabled" },
    { 7, "warning", "warning", "warning", "no warning" },
    { 8, "no_lag_error", "positioning: no lag error; velocity: required and actual value within tolerance" },
    { 9, "control_requested", "control requested, always 1" },
    { 10, "target_reached", "positioning: target position reached; velocity: always 1" },
    { 11, "reference_point_set", "reference point set, always 1" },
    { 12, "job_toggle", "positioning: acknowledgement of target value; velocity: always 1" },
    { 13, "standstill", "drive stands still", "stands still", "travels" },
    { 14, "limit_exceeded", "positioning: limiting value exceeded; velocity: always 0" },
    { 15, "ready_to_travel", "ready to travel", "ready to travel", "not ready to travel" },
}
local SSW_BITS = {
    { 3, "in_position", "in position" },
    { 4, "travels", "drive travels", "travels", "stands still" },
    { 5, "above_upper_limit", "upper limit (positioning)", "above the upper limit", "not above the upper limit" },
    { 6, "below_lower_limit", "lower limit (positioning)", "below the lower limit", "not below the lower limit" },
    { 7, "motor_released", "driver state", "motor released", "motor in control" },
    { 8, "fault", "fault", "FAULT", "no fault" },
    { 9, "loop_travel", "loop travel (positioning)", "travels against the approach direction", "travels in the approach direction" },
    { 10, "no_output_stage", "enable input or supply of the output stage", "output stage not enabled or not supplied", "output stage enabled and supplied" },
    { 11, "not_ready_to_travel", "ready to travel", "not ready to travel", "ready to travel" },
    { 12, "battery_low", "battery voltage", "battery low", "battery in order" },
    { 13, "current_out_of_range", "motor current", "motor current out of range", "motor current in range" },
    { 14, "positioning_active", "positioning (positioning)", "positioning active", "no positioning active" },
    { 15, "lag_error", "lag error", "lag error", "no lag error" },
}
-- end of the generated tables

----------------------------------------------------------------------------------------------------------- fields


-- Every field by its name; the two readings of ppo.pkw.ak by "job" and "answer".
local field = {}

local function u8(name, text, names, mask, form)
    field[name] = ProtoField.uint8(name, text, form or base.DEC, names, mask)
end

local function u16(name, text, form, names, mask)
    field[name] = ProtoField.uint16(name, text, form, names, mask)
end

-- Bits of an octet or a word: { number, name, text, words for 1, words for 0 }. What is returned adds them to a tree.
local function bits(prefix, width, rows)
    local list = {}
    for _, row in ipairs(rows) do
        local name = prefix .. "." .. row[2]
        field[name] = ProtoField.bool(name, row[3], width, row[4] and { row[4], row[5] }, math.floor(2 ^ row[1]))
        table.insert(list, field[name])
    end
    return function(tree, range)
        for _, one in ipairs(list) do tree:add(one, range) end
    end
end

local function plain(kind, name, text, ...)
    field[name] = ProtoField[kind](name, text, ...)
end

u8("profibus.fdl.sd", "Start delimiter SD", START_DELIMITER, nil, base.HEX)
u8("profibus.fdl.le", "Length LE")
u8("profibus.fdl.ler", "Length repeated LEr")
u8("profibus.fdl.da", "Destination address DA", nil, 0x7F)
u8("profibus.fdl.sa", "Source address SA", nil, 0x7F)
u8("profibus.fdl.dsap", "Destination SAP")
u8("profibus.fdl.ssap", "Source SAP")
u8("profibus.fdl.fc", "Function code FC", nil, nil, base.HEX)
plain("bool", "profibus.fdl.fc.request", "Kind", 8, { "request", "response" }, 0x40)
plain("bool", "profibus.fdl.fc.fcb", "Frame count bit FCB", 8, nil, 0x20)
plain("bool", "profibus.fdl.fc.fcv", "Frame count bit valid FCV", 8, nil, 0x10)
u8("profibus.fdl.fc.function", "Function", REQUEST, 0x0F, base.HEX)
u8("profibus.fdl.fc.station", "Station type", STATION_TYPE, 0x30)
u8("profibus.fdl.fc.status", "Status", STATUS, 0x0F, base.HEX)
u8("profibus.fdl.fcs", "Frame check sequence FCS", nil, nil, base.HEX)
plain("bool", "profibus.fdl.fcs.good", "FCS is right")
u8("profibus.fdl.ed", "End delimiter ED", nil, nil, base.HEX)
plain("bool", "profibus.fdl.retry", "Retry: the same frame count as before")
plain("bytes", "profibus.invalid", "Octets that are no telegram")
plain("framenum", "profibus.request_in", "Request in", base.NONE, frametype.REQUEST)
plain("framenum", "profibus.response_in", "Response in", base.NONE, frametype.RESPONSE)
plain("relative_time", "profibus.response_time", "Time since the request")

plain("string", "profibus.dp.service", "Service")
plain("bytes", "profibus.dp.data", "Data")
plain("string", "profibus.dp.identifier", "Configuration identifier")

local prm_bits = bits("profibus.dp.prm", 8, PRM_BITS)
u8("profibus.dp.prm.wd_fact_1", "WD_Fact_1")
u8("profibus.dp.prm.wd_fact_2", "WD_Fact_2")
plain("uint32", "profibus.dp.prm.watchdog", "Watchdog time in ms", base.DEC)
u8("profibus.dp.prm.min_tsdr", "min T_SDR in bit times")
u16("profibus.dp.prm.ident", "Ident_Number", base.HEX)
u8("profibus.dp.prm.group", "Group_Ident", nil, nil, base.HEX)
plain("bytes", "profibus.dp.prm.user", "User_Prm_Data")

local diag_bits_1 = bits("profibus.dp.diag", 8, DIAG_BITS_1)
local diag_bits_2 = bits("profibus.dp.diag", 8, DIAG_BITS_2)
local diag_bits_3 = bits("profibus.dp.diag", 8, DIAG_BITS_3)
u8("profibus.dp.diag.master_add", "Master_Add (255: none)")
u16("profibus.dp.diag.ident", "Ident_Number", base.HEX)
plain("bytes", "profibus.dp.diag.block", "Ext_Diag_Data block")

local control_bits = bits("profibus.dp.gc", 8, CONTROL_BITS)
u8("profibus.dp.gc.group", "Group_Select (0: all)", nil, nil, base.HEX)

u8("profibus.dp.ssa.address", "New_Slave_Add")
u16("profibus.dp.ssa.ident", "Ident_Number", base.HEX)
plain("bool", "profibus.dp.ssa.no_add_chg", "No_Add_Chg")
plain("bytes", "profibus.dp.ssa.remote", "Rem_Slave_Data")

u8("profibus.v1.function", "Function_Num", V1_FUNCTION, 0x7F, base.HEX)
plain("bool", "profibus.v1.refused", "Refused", 8, nil, 0x80)
u8("profibus.v1.slot", "Slot_Number (0: the station)")
u8("profibus.v1.index", "Index")
u8("profibus.v1.length", "Length")
plain("bytes", "profibus.v1.data", "Data of the record")
u8("profibus.v1.error_decode", "Error_Decode", nil, nil, base.HEX)
u8("profibus.v1.error", "Error_Code_1", V1_ERROR, nil, base.HEX)
u8("profibus.v1.error_code_2", "Error_Code_2", nil, nil, base.HEX)
u8("profibus.v1.alarm_type", "Alarm_Type", { [1] = "diagnostic", [2] = "process", [3] = "pull", [4] = "plug", [5] = "status", [6] = "update" })
u8("profibus.v1.alarm_number", "Seq_Nr", nil, 0xF8)
u8("profibus.v1.sap", "Server_SAP")
u16("profibus.v1.send_timeout", "Send_Timeout in 10 ms", base.DEC)
plain("bytes", "profibus.v1.more", "Further octets")

u8("profibus.parameter.reference", "Request_Reference")
u8("profibus.parameter.id", "Request_ID", { [1] = "read", [2] = "change" }, 0x7F)
plain("bool", "profibus.parameter.failed", "Some were refused", 8, nil, 0x80)
u8("profibus.parameter.axis", "Axis or DO-ID")
u8("profibus.parameter.count", "No_of_Parameters")
u8("profibus.parameter.attribute", "Attribute", { [0x10] = "value", [0x20] = "description", [0x30] = "text" }, nil, base.HEX)
u8("profibus.parameter.elements", "No_of_Elements (0: no array)")
u16("profibus.parameter.pnu", "Parameter number PNU", base.DEC)
u16("profibus.parameter.subindex", "Sub-index", base.DEC)
u8("profibus.parameter.format", "Format", FORMAT, nil, base.HEX)
u8("profibus.parameter.values", "No_of_Values")
plain("bytes", "profibus.parameter.value", "Values")
u16("profibus.parameter.error", "Error number", base.DEC, PARAMETER_ERROR)

-- Two fields of one name: a filter meets both.
field.job = ProtoField.uint16("ppo.pkw.ak", "Job", base.DEC, JOB, 0xF000)
field.answer = ProtoField.uint16("ppo.pkw.ak", "Answer", base.DEC, ANSWER, 0xF000)
plain("bool", "ppo.pkw.spm", "SPM, without function", 16, nil, 0x0800)
u16("ppo.pkw.pnu", "Parameter number PNU", base.DEC, PNU, 0x07FF)
u16("ppo.pkw.ind", "Index IND", base.HEX)
plain("uint32", "ppo.pkw.pwe", "Value PWE", base.DEC_HEX)
plain("int32", "ppo.pkw.value", "Value PWE, signed", base.DEC)
u16("ppo.pkw.error", "Error number", base.DEC, PKW_ERROR)

u16("ppo.stw", "Control word STW", base.HEX)
local stw_bits = bits("ppo.stw", 16, STW_BITS)
plain("int32", "ppo.hsw", "Setpoint HSW", base.DEC)

u16("ppo.zsw", "Status word ZSW", base.HEX)
local zsw_bits = bits("ppo.zsw", 16, ZSW_BITS)
u16("ppo.ssw", "System status word SSW", base.HEX)
local ssw_bits = bits("ppo.ssw", 16, SSW_BITS)
plain("int32", "ppo.hiw", "Actual value HIW", base.DEC)


-- Expert information: what an analyst should look at.
local function expert_info(name, text, group, severity)
    return ProtoExpert.new(name, text, expert.group[group], expert.severity[severity])
end

local INVALID = expert_info("profibus.expert.invalid", "No telegram", "MALFORMED", "ERROR")
local WRONG_FCS = expert_info("profibus.expert.fcs", "Wrong FCS", "CHECKSUM", "ERROR")
local WRONG_LENGTH = expert_info("profibus.expert.length", "Wrong length", "PROTOCOL", "WARN")
local REFUSED = expert_info("profibus.expert.refused", "Refused", "RESPONSE_CODE", "NOTE")
local ALONE = expert_info("profibus.expert.alone", "Response without request", "SEQUENCE", "NOTE")
local RETRY = expert_info("profibus.expert.retry", "Retry", "SEQUENCE", "NOTE")
local PRM_FAULT = expert_info("profibus.expert.prm_fault", "Prm_Fault: Set_Prm was refused", "RESPONSE_CODE", "WARN")
local CFG_FAULT = expert_info("profibus.expert.cfg_fault", "Cfg_Fault: Chk_Cfg was refused", "RESPONSE_CODE", "WARN")
local WATCHDOG = expert_info("profibus.expert.watchdog", "The DP watchdog has expired", "SEQUENCE", "WARN")
local V1_REFUSED = expert_info("profibus.expert.v1_refused", "A service of DP-V1 was refused", "RESPONSE_CODE", "NOTE")
local PARAMETER_REFUSED = expert_info("profibus.expert.parameter_refused", "A parameter was refused", "RESPONSE_CODE", "NOTE")
local JOB_REFUSED = expert_info("ppo.expert.refused", "Job not executable", "RESPONSE_CODE", "NOTE")
local FAULT = expert_info("ppo.expert.fault", "The drive has a fault", "RESPONSE_CODE", "WARN")

fdl.experts = { INVALID, WRONG_FCS, WRONG_LENGTH, REFUSED, ALONE, RETRY, PRM_FAULT, CFG_FAULT, WATCHDOG, V1_REFUSED,
    PARAMETER_REFUSED }
ppo.experts = { JOB_REFUSED, FAULT }

local fdl_fields, ppo_fields = {}, {}
for name, one in pairs(field) do
    table.insert(name:find("^profibus") and fdl_fields or ppo_fields, one)
end
fdl.fields = fdl_fields
ppo.fields = ppo_fields

local function is_set(value, number)
    return math.floor(value / 2 ^ number) % 2 == 1
end

-- Whether the bit of this name is 1.
local function has(value, rows, name)
    for _, row in ipairs(rows) do
        if row[2] == name then return is_set(value, row[1]) end
    end
end

------------------------------------------------------------------------------- what is remembered between packets

-- By packet number, filled when a packet is seen for the first time: request_in, response_in, response_time, service,
-- retry, configuration, silence (seconds and watchdog in ms of a master that was too late). Wireshark asks for packets again and in any order, so nothing else is read later.
local packets
-- The request that waits for its response.
local pending
-- By station: its last request, for retries, and the configuration it was last checked for.
local last_request, configuration
-- By station: who owns it, its watchdog in ms, and when the owner was answered last. From a Set_Prm that was acknowledged
-- and whose watchdog is on.
local watched

function fdl.init()
    packets, pending, last_request, configuration, watched = {}, nil, {}, {}, {}
end

local function octets(range)
    return range:bytes():tohex()
end

-- A request was seen for the first time.
local function remember_request(packet, request)
    local station = request.da
    local before = last_request[station]
    packet.retry = before ~= nil and request.fcv and before.sa == request.sa and before.fcb == request.fcb
        and before.octets == request.octets
    last_request[station] = request
    packet.configuration = configuration[station]
    if request.service == "Chk_Cfg" then
        configuration[station] = request.data
    end
    local owner = watched[station]
    if owner and owner.master == request.sa and (request.time - owner.time) * 1000 > owner.watchdog then
        packet.silence = { seconds = request.time - owner.time, watchdog = owner.watchdog }
        watched[station] = nil
    end
    pending = not UNANSWERED[request.func] and station ~= 127 and request or nil
end

-- The owner of a station has got a response: its watchdog begins anew.
local function feed_watchdog(request, time, ok)
    local owner = watched[request.da]
    if request.service == "Set_Prm" and ok and request.watchdog then
        watched[request.da] = request.watchdog.on and { master = request.sa, watchdog = request.watchdog.time, time = time } or nil
    elseif owner and owner.master == request.sa and ok then
        owner.time = time
    end
end

-- A response was seen for the first time. sa and da are nil for a short acknowledge, which says no address.
local function remember_response(packet, number, time, sa, da, ok, data)
    if not pending or sa and (sa ~= pending.da or da ~= pending.sa) then
        return
    end
    packet.request_in = pending.number
    packet.response_time = time - pending.time
    packet.service = pending.service
    packet.station = pending.da
    packet.configuration = configuration[pending.da]
    local request = packets[pending.number]
    if request then request.response_in = number end
    feed_watchdog(pending, time, ok)
    -- It belongs to nobody: what was acknowledged was refused, or given back.
    if pending.service == "Slave_Diag" and data and data:len() >= 2 and has(data(1, 1):uint(), DIAG_BITS_2, "prm_req") then
        watched[pending.da] = nil
    end
    pending = nil
end

-------------------------------------------------------------------------------------------------------------- PPO

-- With a sub-index that of an array: "945.3 Fault buffer".
local function parameter(pnu, element)
    local number = element and string.format("%d.%d", pnu, element) or tostring(pnu)
    return PNU[pnu] and number .. " " .. PNU[pnu] or number
end

-- The high octet of IND, where that is 0 the low one.
local function sub_index(range)
    local high = range(2, 1):uint()
    return high > 0 and high or range(3, 1):uint()
end

-- The bits of a word that are to be said: by the name of the bit, the words for 1 and for 0, if there are any. true is what
-- the table of the bit has.
local STW_SAID = {
    on = { true, true }, no_off2 = { nil, true }, off3 = { "OFF3" }, enable_operation = { true },
    no_stop = { nil, true }, no_intermediate_stop = { nil, true }, start = { "start" }, acknowledge = { true },
    inch1 = { true }, inch2 = { true },
}
local ZSW_SAID = {
    ready_to_turn_on = { nil, true }, operation_enabled = { true }, fault = { true }, no_off2 = { nil, true },
    turn_on_disabled = { true }, warning = { true }, target_reached = { "target reached" }, standstill = { true, true },
    limit_exceeded = { "limit exceeded" }, ready_to_travel = { nil, true },
}

-- Without `said` the words of each bit that is 1.
local function said_bits(value, rows, said)
    local words = {}
    for _, row in ipairs(rows) do
        local known = said == nil and { true } or said and said[row[2]]
        local word = known and known[is_set(value, row[1]) and 1 or 2]
        if word == true then word = row[is_set(value, row[1]) and 4 or 5] or row[3] end
        if word then table.insert(words, word) end
    end
    return table.concat(words, ", ")
end

-- Answers above the last of ANSWER up to this one are spontaneous messages of the profile.
local LAST_SPONTANEOUS = 12

-- PKE, IND and PWE in 8 octets. Returns the words for the info column, "" if there is nothing to say.
local function pkw(range, tree, is_job)
    local pke, pwe = range(0, 2):uint(), range(4, 4)
    local ak, pnu = math.floor(pke / 0x1000), pke % 0x800
    local names = is_job and JOB or ANSWER
    -- Of an array: reading and writing elements, and what answers them; a refusal shows none.
    local of_array = is_job and (ak == 6 or ak == 7 or ak == 8) or not is_job and (ak == 4 or ak == 5)
    local element = of_array and sub_index(range) or nil
    local branch = tree:add(ppo, range,
        string.format("PKW: %s %s", names[ak] or "undefined " .. ak, ak > 0 and parameter(pnu, element) or ""))
    branch:add(is_job and field.job or field.answer, range(0, 2))
    branch:add(field["ppo.pkw.spm"], range(0, 2))
    branch:add(field["ppo.pkw.pnu"], range(0, 2))
    branch:add(field["ppo.pkw.ind"], range(2, 2))
    if not is_job and ak == 7 then
        local number = range(6, 2):uint()
        branch:add(field["ppo.pkw.error"], range(6, 2))
        local words = string.format("%s not executable: error %d, %s", parameter(pnu), number, PKW_ERROR[number] or "?")
        branch:add_proto_expert_info(JOB_REFUSED, words)
        return words
    end
    branch:add(field["ppo.pkw.pwe"], pwe)
    branch:add(field["ppo.pkw.value"], pwe):set_generated()
    if not is_job and ak == 1 and PNU[pnu] == "System status word" then
        ssw_bits(branch:add(field["ppo.ssw"], range(6, 2)), range(6, 2))
    end
    if ak == 0 then
        return ""
    end
    if not is_job and ak == 8 then
        return "no control rights"
    end
    if not is_job and not ANSWER[ak] then
        return string.format("%s answer %d to %s", ak <= LAST_SPONTANEOUS and "spontaneous" or "reserved", ak, parameter(pnu))
    end
    if not is_job and ak == 3 then
        return string.format("description of %s, element %d: %08X", parameter(pnu), sub_index(range), pwe:uint())
    end
    if not is_job and ak == 6 then
        return string.format("%s has %d elements", parameter(pnu), range(6, 2):uint())
    end
    -- Double words have a sign; words lie in the second half.
    local double = is_job and (ak == 3 or ak == 8) or not is_job and (ak == 2 or ak == 5)
    local value = double and pwe:int() or range(6, 2):uint()
    if not is_job then
        local letter = pnu == 945 and ak == 4 and value > 0x20 and value < 0x7F and string.char(value)
        if PNU[pnu] == "System status word" then
            return string.format("%s = %04X (%s)", parameter(pnu), value, said_bits(value, SSW_BITS))
        end
        return string.format("%s = %d%s", parameter(pnu, element), value, letter and " (" .. letter .. ")" or "")
    end
    local writes = ak == 2 or ak == 3 or ak == 7 or ak == 8
    return string.format("%s %s%s", JOB[ak] or "job " .. ak, parameter(pnu, element), writes and " = " .. value or "")
end

-- The seven words of one Data_Exchange: PKE, IND, PWE, PWE, STW or ZSW, HSW or HIW in two words.
local function dissect_ppo(range, tree, is_output)
    local branch = tree:add(ppo, range, is_output and "PPO, outputs" or "PPO, inputs")
    local words = pkw(range(0, 8), branch, is_output)
    local word, value = range(8, 2), range(10, 4)
    local name, bit_fields = "zsw", zsw_bits
    if is_output then name, bit_fields = "stw", stw_bits end
    local item = branch:add(field["ppo." .. name], word)
    bit_fields(item, word)
    local fault = not is_output and has(word:uint(), ZSW_BITS, "fault")
    if fault then
        item:add_proto_expert_info(FAULT)
    end
    branch:add(field[is_output and "ppo.hsw" or "ppo.hiw"], value)
    local said = is_output and said_bits(word:uint(), STW_BITS, STW_SAID) or said_bits(word:uint(), ZSW_BITS, ZSW_SAID)
    return string.format("%s%s %04X (%s), %s %d", words == "" and "" or words .. ", ", name:upper(), word:uint(), said,
        is_output and "HSW" or "HIW", value:int())
end

------------------------------------------------------------------------------------------------------ DP services

-- Each takes the data, never empty, adds them to the tree and returns words for the info column.

local function too_short(range, tree, needed)
    if range:len() >= needed then
        return nil
    end
    local words = string.format("%d octets, expected at least %d", range:len(), needed)
    tree:add(field["profibus.dp.data"], range):add_proto_expert_info(WRONG_LENGTH, words)
    return words
end

-- WD_Fact_1 and 2 of a Set_Prm, in units of 10 ms; a DP-V1 slave may have been told to count in units of 1 ms.
local function watchdog_time(range)
    return 10 * range(1, 1):uint() * range(2, 1):uint()
end

local function set_prm(range, tree)
    local refusal = too_short(range, tree, 7)
    if refusal then return refusal end
    local first = range(0, 1):uint()
    prm_bits(tree, range(0, 1))
    tree:add(field["profibus.dp.prm.wd_fact_1"], range(1, 1))
    tree:add(field["profibus.dp.prm.wd_fact_2"], range(2, 1))
    local watchdog = watchdog_time(range)
    tree:add(field["profibus.dp.prm.watchdog"], range(1, 2), watchdog):set_generated()
    tree:add(field["profibus.dp.prm.min_tsdr"], range(3, 1))
    tree:add(field["profibus.dp.prm.ident"], range(4, 2))
    tree:add(field["profibus.dp.prm.group"], range(6, 1))
    if range:len() > 7 then
        tree:add(field["profibus.dp.prm.user"], range(7))
    end
    local lock = has(first, PRM_BITS, "unlock_req") and "unlock" or has(first, PRM_BITS, "lock_req") and "lock"
        or "min T_SDR only"
    return string.format("%s, watchdog %s, ident %04X", lock, has(first, PRM_BITS, "wd_on") and watchdog .. " ms" or "off",
        range(4, 2):uint())
end

local function diagnosis_blocks(range, tree)
    local at = 0
    while at < range:len() do
        local header = range(at, 1):uint()
        local kind, len = math.floor(header / 64), header % 64
        local name = "identifier-related"
        if kind == 0 then name = "device-related" end
        if kind == 2 then name, len = "channel-related", 3 end
        if kind == 3 then name, len = "revision number", 1 end
        local held = math.min(math.max(len, 1), range:len() - at)
        local item = tree:add(field["profibus.dp.diag.block"], range(at, held))
        item:append_text(" (" .. name .. ")")
        if held ~= len then
            item:add_proto_expert_info(WRONG_LENGTH, string.format("block of %d octets, %d are left", len, held))
        end
        at = at + held
    end
end

-- What the info column shows of a diagnosis: octet, its bits, name.
local DIAGNOSIS_WORDS = {
    { 1, DIAG_BITS_1, "Prm_Fault" }, { 1, DIAG_BITS_1, "Cfg_Fault" }, { 1, DIAG_BITS_1, "Not_Supported" },
    { 1, DIAG_BITS_1, "Ext_Diag" }, { 2, DIAG_BITS_2, "Prm_Req" }, { 1, DIAG_BITS_1, "Station_Not_Ready" },
    { 2, DIAG_BITS_2, "Stat_Diag" }, { 2, DIAG_BITS_2, "Sync_Mode" }, { 2, DIAG_BITS_2, "Freeze_Mode" },
}

local function slave_diag(range, tree)
    local refusal = too_short(range, tree, 6)
    if refusal then return refusal end
    diag_bits_1(tree, range(0, 1))
    diag_bits_2(tree, range(1, 1))
    diag_bits_3(tree, range(2, 1))
    tree:add(field["profibus.dp.diag.master_add"], range(3, 1))
    tree:add(field["profibus.dp.diag.ident"], range(4, 2))
    if range:len() > 6 then
        diagnosis_blocks(range(6), tree)
    end
    for name, info in pairs({ prm_fault = PRM_FAULT, cfg_fault = CFG_FAULT }) do
        if has(range(0, 1):uint(), DIAG_BITS_1, name) then tree:add_proto_expert_info(info) end
    end
    local words = {}
    for _, row in ipairs(DIAGNOSIS_WORDS) do
        if has(range(row[1] - 1, 1):uint(), row[2], row[3]:lower()) then table.insert(words, row[3]) end
    end
    local master = range(3, 1):uint()
    table.insert(words, master == 255 and "no master" or "master " .. master)
    return table.concat(words, ", ")
end

-- A length octet of the special format, or the lower half of a general one.
local function length_words(octet, count)
    return string.format("%d %s%s", count, has(octet, IDENTIFIER_BITS, "unit") and "words" or "octets",
        has(octet, IDENTIFIER_BITS, "consistency") and " consistent" or "")
end

-- Chk_Cfg and Get_Cfg: identifiers in general or special format.
local function configuration_words(range, tree)
    local at = 0
    while at < range:len() do
        local octet = range(at, 1):uint()
        local held, words = 1, nil
        local input, output = has(octet, IDENTIFIER_BITS, "input"), has(octet, IDENTIFIER_BITS, "output")
        if input or output then
            local direction = input and output and "input and output" or output and "output" or "input"
            words = direction .. ", " .. length_words(octet, octet % COUNTS + 1)
        else
            local lengths, parts, maker = {}, {}, octet % COUNTS
            if has(octet, SPECIAL_BITS, "output_length") then table.insert(lengths, "output") end
            if has(octet, SPECIAL_BITS, "input_length") then table.insert(lengths, "input") end
            for n, direction in ipairs(lengths) do
                if at + n < range:len() then
                    local length = range(at + n, 1):uint()
                    table.insert(parts, direction .. ", " .. length_words(length, length % LENGTHS + 1))
                end
            end
            held = 1 + #lengths + (maker ~= NOT_COMPARED and maker or 0)
            words = #lengths == 0 and "empty slot" or #parts == 0 and "cut short" or table.concat(parts, "; ")
        end
        local left = range:len() - at
        local item = tree:add(field["profibus.dp.identifier"], range(at, math.min(held, left)), words)
        if held > left then
            item:add_proto_expert_info(WRONG_LENGTH, string.format("identifier of %d octets, %d are left", held, left))
        end
        at = at + held
    end
    return octets(range)
end

local function global_control(range, tree)
    local refusal = too_short(range, tree, 2)
    if refusal then return refusal end
    local command, group = range(0, 1):uint(), range(1, 1):uint()
    control_bits(tree, range(0, 1))
    tree:add(field["profibus.dp.gc.group"], range(1, 1))
    local words = {}
    for n = #CONTROL_BITS, 1, -1 do
        local bit = CONTROL_BITS[n]
        if is_set(command, bit[1]) then table.insert(words, bit[3]) end
    end
    table.insert(words, group == 0 and "all groups" or string.format("groups %02X", group))
    return table.concat(words, ", ")
end

local function set_slave_add(range, tree)
    local refusal = too_short(range, tree, 4)
    if refusal then return refusal end
    tree:add(field["profibus.dp.ssa.address"], range(0, 1))
    tree:add(field["profibus.dp.ssa.ident"], range(1, 2))
    tree:add(field["profibus.dp.ssa.no_add_chg"], range(3, 1))
    if range:len() > 4 then
        tree:add(field["profibus.dp.ssa.remote"], range(4))
    end
    return "new address " .. range(0, 1):uint()
end

-- Outputs or inputs: a PPO if they have its length and no configuration says otherwise.
local function process_data(range, tree, is_output, checked)
    if range:len() == PPO_LEN and (checked == nil or PPO_CONFIGURATION[checked]) then
        return dissect_ppo(range, tree, is_output)
    end
    tree:add(field["profibus.dp.data"], range)
    return string.format("%d octets of %s", range:len(), is_output and "outputs" or "inputs")
end

----------------------------------------------------------------------------------------------------------- DP-V1

-- What a SAP of a slave is for.
local function sap_name(sap)
    if SERVICE_OF_SAP[sap] then return SERVICE_OF_SAP[sap] end
    if sap == 51 then return "MS1" end
    if sap == 50 then return "MS1 alarms" end
    if sap == 49 then return "MS2 resource manager" end
    if sap < 49 then return "MS2 SAP " .. sap end
    return "SAP " .. sap
end

-- The values of one parameter at `at`: where they end, and words. Nil if they are cut off.
local function parameter_values(range, tree, at)
    if range:len() < at + 2 then return nil end
    local format, count = range(at, 1):uint(), range(at + 1, 1):uint()
    local size = FORMAT_SIZE[format]
    local len = size and size * count
    if not len or range:len() < at + 2 + len then return nil end
    tree:add(field["profibus.parameter.format"], range(at, 1))
    tree:add(field["profibus.parameter.values"], range(at + 1, 1))
    local words = FORMAT[format]
    if len > 0 then
        local values = range(at + 2, len)
        if format == 0x44 and len >= 2 then
            local item = tree:add(field["profibus.parameter.error"], values(0, 2))
            words = string.format("error %02X, %s", values(0, 2):uint(), PARAMETER_ERROR[values(0, 2):uint()] or "of the manufacturer")
            if len >= 4 then words = words .. string.format(" (%d)", values(2, 2):uint()) end
            item:add_proto_expert_info(PARAMETER_REFUSED, words)
        else
            tree:add(field["profibus.parameter.value"], values)
            words = octets(values)
        end
    end
    return math.min(at + 2 + len + len % 2, range:len()), words
end

-- Record 47: a request if it is written, a response if it is read.
local function parameters(range, tree, is_request)
    if range:len() < 4 then
        tree:add(field["profibus.v1.data"], range)
        return string.format("%d octets", range:len())
    end
    tree:add(field["profibus.parameter.reference"], range(0, 1))
    tree:add(field["profibus.parameter.id"], range(1, 1))
    tree:add(field["profibus.parameter.failed"], range(1, 1))
    tree:add(field["profibus.parameter.axis"], range(2, 1))
    tree:add(field["profibus.parameter.count"], range(3, 1))
    local id, count, at, words = range(1, 1):uint(), range(3, 1):uint(), 4, {}
    if is_request then
        for _ = 1, count do
            if range:len() < at + 6 then table.insert(words, "[cut off]") break end
            tree:add(field["profibus.parameter.attribute"], range(at, 1))
            tree:add(field["profibus.parameter.elements"], range(at + 1, 1))
            tree:add(field["profibus.parameter.pnu"], range(at + 2, 2))
            tree:add(field["profibus.parameter.subindex"], range(at + 4, 2))
            table.insert(words, string.format("PNU %d.%d", range(at + 2, 2):uint(), range(at + 4, 2):uint()))
            at = at + 6
        end
    end
    if id == 2 and is_request or id ~= 2 and not is_request then
        for _ = 1, count do
            local behind, said = parameter_values(range, tree, at)
            if not behind then table.insert(words, "[cut off]") break end
            at = behind
            table.insert(words, said)
        end
    end
    if at < range:len() then tree:add(field["profibus.v1.more"], range(at)) end
    return string.format("%s %s", id % 128 == 1 and "read" or id % 128 == 2 and "change" or "?", table.concat(words, ", "))
end

-- A PDU of DP-V1.
local function acyclic(range, tree, is_request)
    local octet = range(0, 1)
    tree:add(field["profibus.v1.function"], octet)
    tree:add(field["profibus.v1.refused"], octet)
    local function_number, len = octet:uint(), range:len()
    local name = V1_FUNCTION[function_number % 128] or string.format("function %02X", function_number)
    if not is_request and function_number >= 128 and len == 4 then
        tree:add(field["profibus.v1.error_decode"], range(1, 1))
        local item = tree:add(field["profibus.v1.error"], range(2, 1))
        tree:add(field["profibus.v1.error_code_2"], range(3, 1))
        local code = range(2, 1):uint()
        local words = string.format("%s refused: %02X, %s", name, code, V1_ERROR[code] or "of the device")
        item:add_proto_expert_info(V1_REFUSED, words)
        return words
    end
    if (name == "Read" or name == "Write" or name == "Data_Transport") and len >= 4 then
        tree:add(field["profibus.v1.slot"], range(1, 1))
        tree:add(field["profibus.v1.index"], range(2, 1))
        tree:add(field["profibus.v1.length"], range(3, 1))
        local slot, index = range(1, 1):uint(), range(2, 1):uint()
        local words = string.format("%s slot %d index %d", name, slot, index)
        if len == 4 then return words end
        local data = range(4)
        local is_parameters = index == 47 and (name == "Write") == is_request
        if is_parameters then return words .. ": " .. parameters(data, tree:add(fdl, data, "Parameters"), is_request) end
        tree:add(field["profibus.v1.data"], data)
        return words .. ": " .. octets(data)
    end
    if name == "Alarm_Ack" and len == 4 then
        tree:add(field["profibus.v1.slot"], range(1, 1))
        tree:add(field["profibus.v1.alarm_type"], range(2, 1))
        tree:add(field["profibus.v1.alarm_number"], range(3, 1))
        return string.format("Alarm_Ack slot %d type %d number %d", range(1, 1):uint(), range(2, 1):uint(),
            math.floor(range(3, 1):uint() / 8))
    end
    if name == "RM" and len == 4 then
        tree:add(field["profibus.v1.sap"], range(1, 1))
        tree:add(field["profibus.v1.send_timeout"], range(2, 2))
        return string.format("RM SAP %d", range(1, 1):uint())
    end
    if name == "Initiate" and is_request and len >= 6 then
        tree:add(field["profibus.v1.send_timeout"], range(4, 2))
    end
    if len > 1 then tree:add(field["profibus.v1.more"], range(1)) end
    return name
end

-- The data of a request or a response. range is nil if there are none.
local function dissect_service(service, range, tree, is_request, checked)
    if not range then
        return nil
    end
    if service == "Data_Exchange" then return process_data(range, tree, is_request, checked) end
    if service == "RD_Inp" and not is_request then return process_data(range, tree, false, checked) end
    if service == "RD_Outp" and not is_request then return process_data(range, tree, true, checked) end
    if service == "Slave_Diag" and not is_request then return slave_diag(range, tree) end
    if service == "Get_Cfg" and not is_request then return configuration_words(range, tree) end
    if service == "Set_Prm" and is_request then return set_prm(range, tree) end
    if service == "Chk_Cfg" and is_request then return configuration_words(range, tree) end
    if service == "Global_Control" and is_request then return global_control(range, tree) end
    if service == "Set_Slave_Add" and is_request then return set_slave_add(range, tree) end
    if service and service:find("^MS[12]") then return acyclic(range, tree, is_request) end
    tree:add(field["profibus.dp.data"], range)
    return string.format("%d octets", range:len())
end

-------------------------------------------------------------------------------------------------------------- FDL

-- What a buffer is: head (octets before DA), pdu (octets behind FC), total; or only the reason why it is no telegram.
local function frame_of(tvb)
    local len, sd = tvb:len(), tvb(0, 1):uint()
    local head, pdu
    if sd == 0xE5 then
        head, pdu = nil, nil
    elseif sd == 0x10 then
        head, pdu = 1, 0
    elseif sd == 0xA2 then
        head, pdu = 1, 8
    elseif sd == 0x68 then
        local function octet(at) return at < len and tvb(at, 1):uint() or nil end
        local le, ler, again = octet(1), octet(2), octet(3)
        if le and (le < 4 or le > 249) then return { reason = string.format("LE is %d, expected 4 to 249", le) } end
        if ler and ler ~= le then return { reason = string.format("LEr is %d, expected %d as in LE", ler, le) } end
        if again and again ~= 0x68 then return { reason = string.format("second start delimiter is %02X", again) } end
        if not again then return { reason = string.format("broken off after %d octets", len) } end
        head, pdu = 4, le - 3
    elseif sd ~= 0xDC then
        return { reason = string.format("octet %02X starts no telegram", sd) }
    end
    local total = sd == 0xE5 and 1 or sd == 0xDC and 3 or head + 3 + pdu + 2
    if len < total then return { reason = string.format("broken off after %d of %d octets", len, total) } end
    if sd ~= 0xE5 and sd ~= 0xDC and tvb(total - 1, 1):uint() ~= 0x16 then
        return { reason = string.format("end delimiter is %02X, expected 16", tvb(total - 1, 1):uint()) }
    end
    return { sd = sd, head = head, pdu = pdu, total = total }
end

-- The octets of the head and the end; the function code bit by bit.
local function add_frame(tvb, tree, frame, is_request)
    local head, total = frame.head, frame.total
    tree:add(field["profibus.fdl.sd"], tvb(0, 1))
    if frame.sd == 0x68 then
        tree:add(field["profibus.fdl.le"], tvb(1, 1))
        tree:add(field["profibus.fdl.ler"], tvb(2, 1))
    end
    tree:add(field["profibus.fdl.da"], tvb(head, 1))
    tree:add(field["profibus.fdl.sa"], tvb(head + 1, 1))
    local code = tvb(head + 2, 1)
    local item = tree:add(field["profibus.fdl.fc"], code)
    item:add(field["profibus.fdl.fc.request"], code)
    if is_request then
        item:add(field["profibus.fdl.fc.fcb"], code)
        item:add(field["profibus.fdl.fc.fcv"], code)
        item:add(field["profibus.fdl.fc.function"], code)
    else
        item:add(field["profibus.fdl.fc.station"], code)
        item:add(field["profibus.fdl.fc.status"], code)
    end
    local sum = 0
    for at = head, total - 3 do sum = (sum + tvb(at, 1):uint()) % 256 end
    local found = tvb(total - 2, 1)
    local fcs = tree:add(field["profibus.fdl.fcs"], found)
    local good = found:uint() == sum
    fcs:add(field["profibus.fdl.fcs.good"], found, good):set_generated()
    if not good then
        fcs:add_proto_expert_info(WRONG_FCS, string.format("FCS is %02X, expected %02X", found:uint(), sum))
    end
    tree:add(field["profibus.fdl.ed"], tvb(total - 1, 1))
    return good
end

local function service_of_request(func, dsap)
    if func == 0x9 then return "FDL_Status" end
    if func == 0xE then return "Ident" end
    if func == 0xF then return "LSAP_Status" end
    if func == 0x0 then return "Time_Event" end
    if dsap then return sap_name(dsap) end
    if func == 0xC or func == 0xD then return "Data_Exchange" end
    return REQUEST[func] or string.format("function %X", func)
end

local function link(tree, packet)
    if packet.request_in then
        tree:add(field["profibus.request_in"], packet.request_in):set_generated()
        local seconds = math.floor(packet.response_time)
        local rest = math.floor((packet.response_time - seconds) * 1e9 + 0.5)
        tree:add(field["profibus.response_time"], NSTime.new(seconds, rest)):set_generated()
    end
    if packet.response_in then
        tree:add(field["profibus.response_in"], packet.response_in):set_generated()
    end
end

-- Takes the extension octets off the data unit: SAPs and the range of the data, nil if there are none. Words if the
-- extension octets are missing.
local function extensions(tvb, tree, frame, da, sa)
    local at, left, found = frame.head + 3, frame.pdu, {}
    for _, row in ipairs({ { da, "dsap" }, { sa, "ssap" } }) do
        if is_set(row[1], 7) then
            if left == 0 then return nil, nil, nil, "an extension octet is missing" end
            tree:add(field["profibus.fdl." .. row[2]], tvb(at, 1))
            found[row[2]] = tvb(at, 1):uint()
            at, left = at + 1, left - 1
        end
    end
    return found.dsap, found.ssap, left > 0 and tvb(at, left) or nil, nil
end

-- SD1, SD2 or SD3. Returns words for the info column.
local function data_telegram(tvb, pinfo, tree, frame)
    local head = frame.head
    local da, sa, fc = tvb(head, 1):uint(), tvb(head + 1, 1):uint(), tvb(head + 2, 1):uint()
    local is_request = is_set(fc, 6)
    local to, from, func = da % 128, sa % 128, fc % 16
    pinfo.cols.src = tostring(from)
    pinfo.cols.dst = to == 127 and "all" or tostring(to)
    local good = add_frame(tvb, tree, frame, is_request)
    local dsap, ssap, data, missing = extensions(tvb, tree, frame, da, sa)
    if missing then
        tree:add_proto_expert_info(INVALID, missing)
        return missing
    end

    local first = packets[pinfo.number] == nil
    local packet = packets[pinfo.number] or {}
    if first then
        packets[pinfo.number] = packet
        if good and is_request then
            packet.service = service_of_request(func, dsap)
            remember_request(packet, {
                number = pinfo.number, time = pinfo.rel_ts, da = to, sa = from, func = func, fcv = is_set(fc, 4),
                fcb = is_set(fc, 5), service = packet.service, octets = octets(tvb(0, frame.total)),
                data = data and octets(data) or "",
                watchdog = packet.service == "Set_Prm" and data and data:len() >= 3 and {
                    on = has(data(0, 1):uint(), PRM_BITS, "wd_on") and not has(data(0, 1):uint(), PRM_BITS, "unlock_req"),
                    time = watchdog_time(data),
                },
            })
        elseif good then
            remember_response(packet, pinfo.number, pinfo.rel_ts, from, to, func == 0x0 or func == 0x8 or func == 0xA, data)
        end
    end

    local service = packet.service
    if is_request then
        service = service_of_request(func, dsap)
    elseif ssap then
        service = sap_name(ssap)
    elseif not service and data then
        service = "Data_Exchange"
    end
    if service then
        tree:add(field["profibus.dp.service"], service):set_generated()
    end
    local words = { service or "response" }
    link(tree, packet)
    if packet.silence then
        local late = string.format("%.0f ms without an answered request of the owner, the watchdog is %d ms",
            packet.silence.seconds * 1000, packet.silence.watchdog)
        tree:add_proto_expert_info(WATCHDOG, "The DP watchdog has expired: " .. late)
        table.insert(words, "[watchdog expired]")
    end
    if packet.retry then
        tree:add(field["profibus.fdl.retry"], true):set_generated()
        tree:add_proto_expert_info(RETRY)
        table.insert(words, "(retry)")
    end
    if not is_request then
        if not packet.request_in then
            tree:add_proto_expert_info(ALONE)
        end
        if STATUS[func] == nil or func >= 0x1 and func <= 0x3 then
            tree:add_proto_expert_info(REFUSED, STATUS_WORDS[func] or "unknown status")
        end
        if service == "FDL_Status" and func == 0 then
            table.insert(words, STATION_TYPE[math.floor(fc / 16) % 4])
        elseif not data or func ~= 0x8 then
            table.insert(words, string.format("%s: %s%s", STATUS[func] or "status " .. func, STATUS_WORDS[func] or "?",
                data and ";" or ""))
        end
    end
    local said = dissect_service(service, data, data and tree:add(fdl, data, (service or "Data")) or tree, is_request,
        packet.configuration)
    if said then table.insert(words, said) end
    if not good then table.insert(words, "[wrong FCS]") end
    return table.concat(words, " ")
end

local function short_acknowledge(tvb, pinfo, tree)
    local packet = packets[pinfo.number]
    if not packet then
        packet = {}
        packets[pinfo.number] = packet
        remember_response(packet, pinfo.number, pinfo.rel_ts, nil, nil, true)
    end
    tree:add(field["profibus.fdl.sd"], tvb(0, 1))
    if packet.service then
        pinfo.cols.src = tostring(packet.station)
        tree:add(field["profibus.dp.service"], packet.service):set_generated()
    else
        tree:add_proto_expert_info(ALONE)
    end
    link(tree, packet)
    return (packet.service and packet.service .. " " or "") .. "short acknowledge"
end

function fdl.dissector(tvb, pinfo, root)
    local len = tvb:len()
    if len == 0 then
        return 0
    end
    pinfo.cols.protocol = "PROFIBUS"
    local tree = root:add(fdl, tvb())
    local frame = frame_of(tvb)
    local words
    if frame.reason then
        tree:add(field["profibus.invalid"], tvb()):add_proto_expert_info(INVALID, frame.reason)
        words = "[no telegram: " .. frame.reason .. "]"
    elseif frame.sd == 0xE5 then
        words = short_acknowledge(tvb, pinfo, tree)
    elseif frame.sd == 0xDC then
        tree:add(field["profibus.fdl.sd"], tvb(0, 1))
        tree:add(field["profibus.fdl.da"], tvb(1, 1))
        tree:add(field["profibus.fdl.sa"], tvb(2, 1))
        pinfo.cols.src = tostring(tvb(2, 1):uint() % 128)
        pinfo.cols.dst = tostring(tvb(1, 1):uint() % 128)
        words = "token"
    else
        words = data_telegram(tvb, pinfo, tree, frame)
    end
    if frame.total and len > frame.total then
        local rest = tvb(frame.total)
        tree:add(field["profibus.invalid"], rest):add_proto_expert_info(INVALID, "octets behind the telegram")
        words = words .. string.format(" [and %d octets]", rest:len())
    end
    pinfo.cols.info = words
    tree:append_text(", " .. words)
    return len
end

-- Wireshark 4.0 has no number of its own for link type 257: such packets are of unknown encapsulation, 0.
DissectorTable.get("wtap_encap"):add(0, fdl)
