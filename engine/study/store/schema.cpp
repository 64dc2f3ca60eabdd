#include "engine/study/store/schema.h"

#include <fmt/core.h>

#include <string>

namespace springdrive::study {

namespace {

// The columns of each table are listed in fields.h, too; there with their C++ values.
//
// Numbers with fractions are in columns of type ANY, because SQLite reads a -0.0 in a REAL column
// back as 0.0. Child rows are numbered from 1. sha256 is of a row with its child rows:
// rows.cpp.
constexpr const char *kTables = R"(
CREATE TABLE study (
    id INTEGER PRIMARY KEY CHECK (id = 1),
    title TEXT NOT NULL,
    protocol TEXT NOT NULL,
    protocol_sha256 TEXT NOT NULL CHECK (length(protocol_sha256) = 64),
    created_utc TEXT NOT NULL CHECK (length(created_utc) = 24),
    software TEXT NOT NULL,
    records_folder TEXT NOT NULL CHECK (records_folder <> '' AND records_folder NOT GLOB '*/*'),
    removed_participants INTEGER NOT NULL CHECK (removed_participants >= 0),
    is_to_compact INTEGER NOT NULL CHECK (is_to_compact IN (0, 1)),
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64)
) STRICT;
CREATE TABLE participant (
    id INTEGER PRIMARY KEY,
    code TEXT NOT NULL UNIQUE CHECK (length(code) BETWEEN 2 AND 7 AND code GLOB '[A-Z]*[0-9]'),
    number INTEGER NOT NULL UNIQUE CHECK (number >= 1),
    added_utc TEXT NOT NULL CHECK (length(added_utc) = 24),
    is_being_removed INTEGER NOT NULL CHECK (is_being_removed IN (0, 1)),
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64)
) STRICT;
CREATE TABLE session (
    id INTEGER PRIMARY KEY,
    participant TEXT NOT NULL REFERENCES participant (code) ON DELETE CASCADE,
    started_utc TEXT NOT NULL CHECK (length(started_utc) = 24),
    ended_utc TEXT CHECK (length(ended_utc) = 24),
    ending TEXT CHECK (ending IN ('completed', 'stopped', 'left', 'device_lost', 'safety_trip',
                                  'failed', 'interrupted')),
    device_kind TEXT NOT NULL CHECK (device_kind IN ('simulated', 'emulated', 'usb')),
    device_name TEXT NOT NULL,
    device_serial TEXT NOT NULL,
    software TEXT NOT NULL,
    host TEXT NOT NULL,
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64),
    UNIQUE (id, participant),
    CHECK (ended_utc IS NULL OR ending IS NOT NULL)
) STRICT;
CREATE TABLE session_fact (
    session INTEGER NOT NULL REFERENCES session ON DELETE CASCADE,
    number INTEGER NOT NULL,
    name TEXT NOT NULL CHECK (name <> ''),
    value ANY NOT NULL CHECK (typeof(value) IN ('real', 'text')),
    PRIMARY KEY (session, number)
) STRICT;
CREATE TABLE trial (
    id INTEGER PRIMARY KEY,
    participant TEXT NOT NULL REFERENCES participant (code) ON DELETE CASCADE,
    block INTEGER NOT NULL CHECK (block >= 1),
    position INTEGER NOT NULL CHECK (position >= 1),
    attempt INTEGER NOT NULL CHECK (attempt >= 1),
    session INTEGER NOT NULL,
    condition TEXT NOT NULL,
    track TEXT NOT NULL,
    is_practice INTEGER NOT NULL CHECK (is_practice IN (0, 1)),
    is_catch INTEGER NOT NULL CHECK (is_catch IN (0, 1)),
    is_presented_again INTEGER NOT NULL CHECK (is_presented_again IN (0, 1)),
    seed INTEGER NOT NULL,
    level_name TEXT NOT NULL,
    level ANY CHECK (typeof(level) IN ('real', 'null')),
    target INTEGER,
    response TEXT NOT NULL,
    chosen INTEGER,
    adjusted ANY,
    is_correct INTEGER CHECK (is_correct IN (0, 1)),
    response_time_s ANY CHECK (typeof(response_time_s) IN ('real', 'null')),
    at_utc TEXT NOT NULL CHECK (length(at_utc) = 24),
    software TEXT NOT NULL,
    missed_deadlines INTEGER NOT NULL CHECK (missed_deadlines >= 0),
    record_path TEXT CHECK (record_path <> '' AND record_path NOT GLOB '/*'),
    record_sha256 TEXT CHECK (length(record_sha256) = 64),
    repeats_block INTEGER,
    repeats_position INTEGER,
    repeats_attempt INTEGER,
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64),
    UNIQUE (participant, block, position, attempt),
    UNIQUE (participant, repeats_block, repeats_position, repeats_attempt),
    FOREIGN KEY (session, participant) REFERENCES session (id, participant) ON DELETE CASCADE,
    FOREIGN KEY (participant, repeats_block, repeats_position, repeats_attempt)
        REFERENCES trial (participant, block, position, attempt) ON DELETE CASCADE,
    CHECK ((record_path IS NULL) = (record_sha256 IS NULL)),
    CHECK ((repeats_block IS NULL) = (repeats_position IS NULL)
           AND (repeats_block IS NULL) = (repeats_attempt IS NULL)),
    CHECK (CASE response
               WHEN 'none' THEN chosen IS NULL AND adjusted IS NULL
               WHEN 'chosen' THEN chosen >= 1 AND adjusted IS NULL
               WHEN 'yes_no' THEN chosen IN (0, 1) AND adjusted IS NULL
               WHEN 'adjusted' THEN chosen IS NULL AND typeof(adjusted) = 'real'
               ELSE 0 END)
) STRICT;
CREATE TABLE presentation (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    start_s ANY CHECK (typeof(start_s) IN ('real', 'null')),
    end_s ANY CHECK (typeof(end_s) IN ('real', 'null')),
    PRIMARY KEY (trial, number)
) STRICT;
CREATE TABLE stimulus_value (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    presentation INTEGER NOT NULL,
    name TEXT NOT NULL CHECK (name <> ''),
    intended ANY CHECK (typeof(intended) IN ('real', 'null')),
    delivered ANY CHECK (typeof(delivered) IN ('real', 'null')),
    PRIMARY KEY (trial, number),
    FOREIGN KEY (trial, presentation) REFERENCES presentation ON DELETE CASCADE
) STRICT;
CREATE TABLE tuning_value (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    name TEXT NOT NULL CHECK (name <> ''),
    value ANY NOT NULL CHECK (typeof(value) IN ('real', 'text')),
    PRIMARY KEY (trial, number)
) STRICT;
CREATE TABLE winding (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    temperature_degC ANY CHECK (typeof(temperature_degC) IN ('real', 'null')),
    PRIMARY KEY (trial, number)
) STRICT;
CREATE TABLE safety_event (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    time_s ANY CHECK (typeof(time_s) IN ('real', 'null')),
    text TEXT NOT NULL,
    PRIMARY KEY (trial, number)
) STRICT;
CREATE TABLE mark (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    reason TEXT NOT NULL CHECK (reason <> ''),
    PRIMARY KEY (trial, number)
) STRICT;
CREATE TABLE note (
    id INTEGER PRIMARY KEY,
    participant TEXT REFERENCES participant (code) ON DELETE CASCADE,
    session INTEGER,
    at_utc TEXT NOT NULL CHECK (length(at_utc) = 24),
    kind TEXT NOT NULL CHECK (kind <> ''),
    text TEXT NOT NULL,
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64),
    FOREIGN KEY (session, participant) REFERENCES session (id, participant) ON DELETE CASCADE,
    CHECK (session IS NULL OR participant IS NOT NULL)
) STRICT;
CREATE TABLE answer (
    id INTEGER PRIMARY KEY,
    participant TEXT NOT NULL REFERENCES participant (code) ON DELETE CASCADE,
    session INTEGER NOT NULL,
    item TEXT NOT NULL CHECK (item <> ''),
    question TEXT NOT NULL CHECK (question <> ''),
    answer TEXT NOT NULL,
    at_utc TEXT NOT NULL CHECK (length(at_utc) = 24),
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64),
    UNIQUE (session, item),
    FOREIGN KEY (session, participant) REFERENCES session (id, participant) ON DELETE CASCADE
) STRICT;
)";

/// All tables and indices with their SQL, in one text.
std::string tables_of(const Database &database) {
    return database.text(
        "SELECT coalesce(group_concat(line, char(10)), '') FROM (SELECT type || ' ' "
        "|| name || ': ' || coalesce(sql, '') AS line FROM sqlite_schema "
        "WHERE name NOT GLOB 'sqlite_stat*' ORDER BY type, name)");
}

} // namespace

void check_identity(const Database &database) {
    const std::int64_t version = database.number("PRAGMA user_version");
    if (database.number("PRAGMA application_id") != kApplicationId || version < 1) {
        database.refuse("is no study of springdrive, but another SQLite database; name a study "
                        "file");
    }
    if (version != kVersion) {
        database.refuse(fmt::format("is a study of version {}, and this program knows version {} "
                                    "only; open it with {} springdrive",
                                    version, kVersion,
                                    version > kVersion ? "a newer" : "an older"));
    }
}

void check_structure(const Database &database) {
    const std::string found = database.text("PRAGMA integrity_check(1)");
    if (found != "ok") {
        database.refuse_damage(found);
    }
    if (!database.text("SELECT \"table\" FROM pragma_foreign_key_check LIMIT 1").empty()) {
        database.refuse_damage("a row refers to one that is missing");
    }
    const Database model = Database::in_memory(database.shown());
    create_tables(model);
    if (tables_of(database) != tables_of(model)) {
        database.refuse_damage("its tables are not as springdrive made them");
    }
}

void create_tables(const Database &database) {
    Transaction transaction(database, Transaction::Kind::write);
    database.run(kTables);
    database.run(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplicationId,
                             kVersion));
    transaction.commit();
}

} // namespace springdrive::study
