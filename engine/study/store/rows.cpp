#include "engine/study/store/rows.h"

#include "base/sha256.h"
#include "base/text.h"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>

namespace springdrive::study {

namespace {

// Values in the columns of SQLite, and back.

template <std::integral Integer> void store(Statement &row, Integer value) { row.bind(value); }
void store(Statement &row, const std::string &value) { row.bind(value); }
void store(Statement &row, const std::optional<double> &value) { row.bind(value); }
void store(Statement &row, UtcTime value) { row.bind(utc_text(value)); }
void store(Statement &row, DeviceKind value) { row.bind(name_of(value)); }
void store(Statement &row, SessionEnding value) { row.bind(name_of(value)); }
void store(Statement &row, const std::variant<double, std::string> &value) {
    std::visit([&](const auto &one) { row.bind(one); }, value);
}
void store(Statement &row, const TrialPlace &value) {
    row.bind(value.block).bind(value.position).bind(value.attempt);
}
void store(Statement &row, const RecordLink &value) {
    row.bind(value.path.string()).bind(value.sha256);
}
void store(Statement &row, const Response &value) {
    row.bind(kResponseNames[value.index()]);
    const auto *const adjusted = std::get_if<Adjusted>(&value);
    if (const auto *const chosen = std::get_if<Chosen>(&value)) {
        row.bind(chosen->alternative);
    } else if (const auto *const answer = std::get_if<YesNo>(&value)) {
        row.bind(answer->yes);
    } else {
        row.bind_null();
    }
    store(row, adjusted != nullptr ? std::optional(adjusted->level) : std::nullopt);
}

/// How many columns a value takes.
template <typename Value> constexpr int kColumns = 1;
template <> constexpr int kColumns<TrialPlace> = 3;
template <> constexpr int kColumns<RecordLink> = 2;

template <typename Value> void store(Statement &row, const std::optional<Value> &value) {
    if (value) {
        return store(row, *value);
    }
    for (int i = 0; i < kColumns<Value>; ++i) {
        row.bind_null();
    }
}

/// The place of the name that comes next.
template <std::size_t count>
std::size_t place_of_name(Statement &row, const std::array<std::string_view, count> &names) {
    const std::string name = row.text();
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) {
        row.refuse("no such name: " + in_quotes(name));
    }
    return static_cast<std::size_t>(found - names.begin());
}

template <std::integral Integer> void load(Statement &row, Integer &value) {
    value = static_cast<Integer>(row.integer());
}
void load(Statement &row, std::string &value) { value = row.text(); }
void load(Statement &row, double &value) { value = row.real(); }
void load(Statement &row, UtcTime &value) {
    const std::string text = row.text();
    const auto time = utc_time_of(text);
    if (!time) {
        row.refuse("no time: " + in_quotes(text));
    }
    value = *time;
}
void load(Statement &row, DeviceKind &value) {
    value = static_cast<DeviceKind>(place_of_name(row, kDeviceKindNames));
}
void load(Statement &row, SessionEnding &value) {
    value = static_cast<SessionEnding>(place_of_name(row, kSessionEndingNames));
}
void load(Statement &row, std::variant<double, std::string> &value) {
    if (row.is_text()) {
        value = row.text();
    } else {
        value = row.real();
    }
}
void load(Statement &row, TrialPlace &value) {
    load(row, value.block);
    load(row, value.position);
    load(row, value.attempt);
}
void load(Statement &row, RecordLink &value) {
    value.path = row.text();
    value.sha256 = row.text();
}
template <typename Value> void load(Statement &row, std::optional<Value> &value) {
    if (row.is_null()) {
        row.skip(kColumns<Value>);
        value.reset();
    } else {
        load(row, value.emplace());
    }
}
void load(Statement &row, Response &value) {
    const std::size_t kind = place_of_name(row, kResponseNames);
    std::optional<std::int64_t> chosen;
    std::optional<double> adjusted;
    load(row, chosen);
    load(row, adjusted);
    const std::array<Response, kResponseNames.size()> by_kind{
        NoResponse{}, Chosen{static_cast<int>(chosen.value_or(0))}, YesNo{chosen == 1},
        Adjusted{adjusted.value_or(0.0)}};
    value = by_kind[kind];
}

/// SHA-256 of a row with its child rows, stored beside it: by it, a value that the disk changed is
/// detected, where SQLite checks little but the structure.
/// Each value follows its length or the number of its kind, so that no two rows have the same
/// bytes. A NaN counts as not known, as it is stored.
class RowDigest {
public:
    template <typename Row> RowDigest(std::string_view table, std::int64_t id, const Row &row) {
        add(table);
        add(id);
        add_row(row);
    }

    [[nodiscard]] std::string hex() { return sha256_.hex(); }

private:
    template <typename Row> void add_row(const Row &row) {
        for_each_field(row, [&](std::string_view, const auto &value) { add(value); });
        for_each_list(row, [&](std::string_view table, const auto &values) {
            add(table);
            add(values.size());
            for (const auto &value : values) {
                add_row(value);
            }
        });
    }

    void add(std::string_view text) { sha256_.add(text); }
    void add(const std::string &text) { sha256_.add(std::string_view(text)); }
    template <std::integral Integer> void add(Integer number) {
        sha256_.add(static_cast<std::uint64_t>(number));
    }
    void add(double number) { sha256_.add(std::bit_cast<std::uint64_t>(number)); }
    void add(UtcTime time) { add(time.time_since_epoch().count()); }
    void add(DeviceKind kind) { add(name_of(kind)); }
    void add(SessionEnding ending) { add(name_of(ending)); }
    void add(const TrialPlace &place) {
        add(place.block);
        add(place.position);
        add(place.attempt);
    }
    void add(const RecordLink &link) {
        add(link.path.string());
        add(link.sha256);
    }
    void add(const NoResponse & /*none*/) {}
    void add(const Chosen &chosen) { add(chosen.alternative); }
    void add(const YesNo &answer) { add(answer.yes); }
    void add(const Adjusted &adjusted) { add(adjusted.level); }
    template <typename... Kinds> void add(const std::variant<Kinds...> &value) {
        add(value.index());
        std::visit([&](const auto &one) { add(one); }, value);
    }
    void add(const std::optional<double> &number) {
        const bool is_known = number && !std::isnan(*number);
        add(is_known);
        if (is_known) {
            add(*number);
        }
    }
    template <typename Value> void add(const std::optional<Value> &value) {
        add(value.has_value());
        if (value) {
            add(*value);
        }
    }

    Sha256 sha256_;
};

template <typename Row> constexpr std::string_view kTable;
template <> constexpr std::string_view kTable<StudyRow> = "study";
template <> constexpr std::string_view kTable<ParticipantRow> = "participant";
template <> constexpr std::string_view kTable<Session> = "session";
template <> constexpr std::string_view kTable<Trial> = "trial";
template <> constexpr std::string_view kTable<QuestionnaireAnswer> = "answer";
template <> constexpr std::string_view kTable<Note> = "note";

/// "code, number, added_utc, "
template <typename Row> std::string columns_of(const Row &row) {
    std::string columns;
    for_each_field(row, [&](std::string_view names, const auto &) {
        columns += names;
        columns += ", ";
    });
    return columns;
}

/// "?, ?, ?" for that many columns, which are separated by commas.
std::string places_for(std::string_view columns) {
    std::string places = "?";
    for (auto i = std::ranges::count(columns, ','); i > 0; --i) {
        places += ", ?";
    }
    return places;
}

template <typename Row> void store_fields(Statement &statement, const Row &row) {
    for_each_field(row, [&](std::string_view, const auto &value) { store(statement, value); });
}

template <typename Row> void load_fields(Statement &statement, Row &row) {
    for_each_field(row, [&](std::string_view, auto &value) { load(statement, value); });
}

template <typename Row>
void insert_lists(const Database &database, std::int64_t id, const Row &row) {
    for_each_list(row, [&]<typename Child>(std::string_view table, const std::vector<Child> &list) {
        const std::string columns = columns_of(Child{}) + std::string(kTable<Row>) + ", number";
        Statement insertion = database.prepare(
            fmt::format("INSERT INTO {} ({}) VALUES ({})", table, columns, places_for(columns)));
        for (std::size_t i = 0; i < list.size(); ++i) {
            store_fields(insertion, list[i]);
            insertion.bind(id).bind(i + 1).run();
        }
    });
}

template <typename Row> void load_lists(const Database &database, std::vector<Numbered<Row>> &of) {
    std::vector<Statement> selections; // one a list
    const Row any{};
    for_each_list(any, [&]<typename Child>(std::string_view table, const std::vector<Child> &) {
        selections.push_back(
            database.prepare(fmt::format("SELECT {}number FROM {} WHERE {} = ? ORDER BY number",
                                         columns_of(Child{}), table, kTable<Row>)));
    });
    for (Numbered<Row> &one : of) {
        auto selection = selections.begin();
        for_each_list(one.row, [&](std::string_view, auto &list) {
            selection->bind(one.id);
            while (selection->next()) {
                load_fields(*selection, list.emplace_back());
            }
            ++selection;
        });
    }
}

} // namespace

template <typename Row> std::string digest_of(std::int64_t id, const Row &row) {
    return RowDigest(kTable<Row>, id, row).hex();
}

template <typename Row> std::int64_t insert(const Database &database, const Row &row) {
    const std::string_view table = kTable<Row>;
    const std::int64_t id =
        database.number(fmt::format("SELECT coalesce(max(id), 0) + 1 FROM {}", table));
    const std::string columns = columns_of(row) + "id, sha256";
    Statement insertion = database.prepare(
        fmt::format("INSERT INTO {} ({}) VALUES ({})", table, columns, places_for(columns)));
    store_fields(insertion, row);
    insertion.bind(id).bind(digest_of(id, row)).run();
    insert_lists(database, id, row);
    return id;
}

template <typename Row> void update(const Database &database, const Numbered<Row> &numbered) {
    const std::int64_t id = numbered.id;
    const Row &row = numbered.row;
    const std::string_view table = kTable<Row>;
    const std::string columns = columns_of(row) + "sha256";
    Statement change = database.prepare(
        fmt::format("UPDATE {} SET ({}) = ({}) WHERE id = ?", table, columns, places_for(columns)));
    store_fields(change, row);
    change.bind(digest_of(id, row)).bind(id).run();
    for_each_list(row, [&](std::string_view child_table, const auto &) {
        database.run(fmt::format("DELETE FROM {} WHERE {} = {}", child_table, table, id));
    });
    insert_lists(database, id, row);
}

template <typename Row>
std::vector<Numbered<Row>> rows(const Database &database, std::optional<std::int64_t> id) {
    const std::string_view table = kTable<Row>;
    std::vector<Numbered<Row>> found;
    std::vector<std::string> digests;
    Statement selection = database.prepare(
        fmt::format("SELECT {}id, sha256 FROM {} {} ORDER BY id", columns_of(Row{}), table,
                    id ? fmt::format("WHERE id = {}", *id) : ""));
    while (selection.next()) {
        Numbered<Row> &numbered = found.emplace_back();
        load_fields(selection, numbered.row);
        numbered.id = selection.integer();
        digests.push_back(selection.text());
    }
    load_lists(database, found);
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (digests[i] != digest_of(found[i].id, found[i].row)) {
            database.refuse_damage(
                fmt::format("row {} of table {} has changed", found[i].id, table));
        }
    }
    return found;
}

template std::int64_t insert(const Database &, const StudyRow &);
template std::int64_t insert(const Database &, const ParticipantRow &);
template std::int64_t insert(const Database &, const Session &);
template std::int64_t insert(const Database &, const Trial &);
template std::int64_t insert(const Database &, const QuestionnaireAnswer &);
template std::int64_t insert(const Database &, const Note &);
template std::string digest_of(std::int64_t, const Trial &);
template void update(const Database &, const Numbered<StudyRow> &);
template void update(const Database &, const Numbered<ParticipantRow> &);
template void update(const Database &, const Numbered<Session> &);
template void update(const Database &, const Numbered<Trial> &);
template void update(const Database &, const Numbered<QuestionnaireAnswer> &);
template void update(const Database &, const Numbered<Note> &);
template std::vector<Numbered<StudyRow>> rows(const Database &, std::optional<std::int64_t>);
template std::vector<Numbered<ParticipantRow>> rows(const Database &, std::optional<std::int64_t>);
template std::vector<Numbered<Session>> rows(const Database &, std::optional<std::int64_t>);
template std::vector<Numbered<Trial>> rows(const Database &, std::optional<std::int64_t>);
template std::vector<Numbered<QuestionnaireAnswer>> rows(const Database &,
                                                         std::optional<std::int64_t>);
template std::vector<Numbered<Note>> rows(const Database &, std::optional<std::int64_t>);

Numbered<StudyRow> study_row(const Database &database) {
    const auto found = rows<StudyRow>(database);
    if (found.empty()) {
        database.refuse_damage("the study's own row is missing");
    }
    if (const std::string problem = validate_records_folder(found.front().row.facts.records_folder);
        !problem.empty()) {
        database.refuse_damage(problem);
    }
    return found.front();
}

std::optional<Numbered<ParticipantRow>> participant_row(const Database &database,
                                                        const std::string &code) {
    Statement selection = database.prepare("SELECT id FROM participant WHERE code = ?");
    if (!selection.bind(code).next()) {
        return std::nullopt;
    }
    const auto found = rows<ParticipantRow>(database, selection.integer());
    return found.front().row.is_being_removed ? std::nullopt : std::optional(found.front());
}

std::optional<Numbered<Trial>> trial_row(const Database &database, const std::string &participant,
                                         const TrialPlace &place) {
    Statement selection = database.prepare("SELECT id FROM trial WHERE participant = ? AND "
                                           "block = ? AND position = ? AND attempt = ?");
    store(selection.bind(participant), place);
    if (!selection.next()) {
        return std::nullopt;
    }
    return rows<Trial>(database, selection.integer()).front();
}

std::optional<QuestionnaireAnswer> answer_row(const Database &database, SessionId session,
                                              const std::string &item) {
    Statement selection = database.prepare("SELECT id FROM answer WHERE session = ? AND item = ?");
    if (!selection.bind(session).bind(item).next()) {
        return std::nullopt;
    }
    return rows<QuestionnaireAnswer>(database, selection.integer()).front().row;
}

bool has_repetition(const Database &database, const std::string &participant,
                    const TrialPlace &place) {
    Statement selection =
        database.prepare("SELECT 1 FROM trial WHERE participant = ? AND repeats_block = ? AND "
                         "repeats_position = ? AND repeats_attempt = ?");
    store(selection.bind(participant), place);
    return selection.next();
}

StudyContents read_contents(const Database &database) {
    StudyContents contents;
    contents.facts = study_row(database).row.facts;
    std::set<std::string, std::less<>> shown;
    const auto check = [&database](const std::string &problem) {
        if (!problem.empty()) {
            database.refuse_damage(problem);
        }
    };
    for (auto &[id, row] : rows<ParticipantRow>(database)) {
        check(validate(row.participant));
        if (row.is_being_removed) {
            contents.unfinished_removals.push_back(row.participant.code);
        } else {
            shown.insert(row.participant.code);
            contents.participants.push_back(row.participant);
        }
    }
    for (auto &[id, session] : rows<Session>(database)) {
        if (shown.contains(session.participant)) {
            session.id = id;
            contents.sessions.push_back(std::move(session));
        }
    }
    std::map<std::pair<std::string, TrialPlace>, std::size_t> places;
    for (auto &[id, trial] : rows<Trial>(database)) {
        check(validate_record(trial, contents.facts.records_folder));
        if (shown.contains(trial.participant)) {
            places.emplace(std::pair(trial.participant, trial.place), contents.trials.size());
            contents.trials.push_back(std::move(trial));
        }
    }
    for (const Trial &trial : std::vector(contents.trials)) {
        if (trial.repetition_of) {
            const auto repeated = places.find({trial.participant, *trial.repetition_of});
            contents.trials[repeated->second].repeated_by = trial.place;
        }
    }
    for (auto &[id, answer] : rows<QuestionnaireAnswer>(database)) {
        if (shown.contains(answer.participant)) {
            contents.answers.push_back(std::move(answer));
        }
    }
    for (auto &[id, note] : rows<Note>(database)) {
        if (!note.participant || shown.contains(*note.participant)) {
            contents.notes.push_back(std::move(note));
        }
    }
    return contents;
}

} // namespace springdrive::study
