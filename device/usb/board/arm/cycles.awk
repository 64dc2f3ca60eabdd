# Instructions and cycles between mark_start and mark_end, from a disassembly and QEMU's log of
# every program counter. Cycles by the tables of the Cortex-M4 Technical Reference Manual (ARM 100166,
# tables 3-1 and 7-1), without wait states; a refill of the pipeline (P) is taken as 2 of 1 to 3.
#
#   awk -f cycles.awk DISASSEMBLY LOG   ->  one line for each pass: instructions, cycles

function registers(operands,   list, count, i, ends) {
    match(operands, /\{.*\}/)
    count = split(substr(operands, RSTART + 1, RLENGTH - 2), list, ",")
    for (i = 1; i in list; i++)
        if (split(list[i], ends, "-") == 2) {
            gsub(/[^0-9]/, "", ends[1]); gsub(/[^0-9]/, "", ends[2])
            count += ends[2] - ends[1]
        }
    return count
}

# Without a taken branch.
function base_cycles(name, operands) {
    if (name ~ /^v(div|sqrt)/) return 14
    if (name ~ /^v(fm|fnm|ml|nml)/) return 3
    if (name ~ /^v(ldm|stm|push|pop)/) return 1 + registers(operands)
    if (name ~ /^v(ldr|str)/) return 2
    if (name ~ /^vmov/ && gsub(/,/, ",", operands) >= 2) return 2
    if (name ~ /^(ldm|stm|push|pop)/) return 1 + registers(operands)
    if (name ~ /^(ldrd|strd)/) return 3
    if (name ~ /^(ldr|str)/) return 2
    if (name ~ /^(udiv|sdiv)/) return 12
    if (name ~ /^(dmb|dsb|isb)/) return 4
    return 1
}

FNR == NR {
    if ($0 ~ /^[0-9a-f]+ <.*>:$/) {
        symbol[substr($2, 2, length($2) - 3)] = $1
        next
    }
    if (split($0, part, "\t") >= 3) {
        address = part[1]; gsub(/[ :]/, "", address)
        while (length(address) < 8) address = "0" address
        bytes = part[2]; gsub(/ /, "", bytes)
        size[address] = length(bytes) / 2
        cost[address] = base_cycles(part[3], part[4])
    }
    next
}

/^Trace/ {
    split($0, field, "/")
    now = tolower(field[2])
    if (last != "") {
        cycles += cost[last]
        instructions++
        if (hex(now) != hex(last) + size[last]) cycles += 2
    }
    if (now == symbol["mark_start"]) {
        instructions = 0
        cycles = 0
        is_counting = 1
    }
    if (now == symbol["mark_end"] && is_counting) {
        print instructions, cycles
        is_counting = 0
        last = ""
        next
    }
    last = is_counting ? now : ""
}

function hex(text,   value, i) {
    if (text in known) return known[text]
    value = 0
    for (i = 1; i <= length(text); i++)
        value = 16 * value + index("0123456789abcdef", substr(text, i, 1)) - 1
    known[text] = value
    return value
}
