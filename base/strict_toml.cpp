#include "base/strict_toml.h"

#include "base/input_error.h"
#include "base/input_file.h"
#include "base/text.h"

#include <fmt/core.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <utility>

namespace springdrive {

struct StrictTomlTable::Contents {
    std::filesystem::path file;
    std::string prefix; ///< "motor." for keys of [motor]
    std::shared_ptr<const toml::table> root;
    const toml::table *table = nullptr; ///< this table, owned by `root`
    std::set<std::string, std::less<>> requested;

    const toml::node *find(std::string_view key) {
        requested.emplace(key);
        return table->get(key);
    }
};

namespace {

/// Far above any device or tuning; a record also keeps its device file in a header of 1 MB.
constexpr std::uintmax_t kMaxBytes = 1U << 20U;

std::string plain(double value) { return fmt::format("{:g}", value); }

std::string allowed(NumberRange range) {
    if (range.minimum == NumberRange{}.minimum && range.maximum == NumberRange{}.maximum) {
        return "a finite number";
    }
    return fmt::format("a number from {:g} to {:g}", range.minimum, range.maximum);
}

/// The value of a TOML integer or float, NaN for anything else.
double as_number(const toml::node &node) {
    return node.is_number() ? node.value<double>().value_or(std::nan("")) : std::nan("");
}

bool lies_in(double value, NumberRange range) {
    return std::isfinite(value) && value >= range.minimum && value <= range.maximum;
}

/// A value as written in the file, on one line, for a message.
std::string as_written(const toml::node &node) {
    std::ostringstream out;
    if (node.is_table() || node.is_array_of_tables()) {
        return "a table";
    }
    if (node.is_number()) {
        return plain(as_number(node));
    }
    node.visit([&out](const auto &value) { out << value; });
    std::string text = out.str();
    for (char &c : text) {
        c = c == '\n' ? ' ' : c;
    }
    return text;
}

/// "on_the_fly, global or by_hand".
std::string any_of(std::span<const std::string_view> names) {
    std::string list(names.front());
    for (std::size_t i = 1; i < names.size(); ++i) {
        list += i + 1 < names.size() ? ", " : " or ";
        list += names[i];
    }
    return list;
}

const toml::node &present(const StrictTomlTable &table, const toml::node *node,
                          std::string_view key, const std::string &expected) {
    if (node == nullptr) {
        table.refuse(key, "is missing; it must be " + expected);
    }
    return *node;
}

[[noreturn]] void refuse_value(const StrictTomlTable &table, std::string_view key,
                               const toml::node &node, const std::string &expected) {
    table.refuse(key, "is " + as_written(node) + "; it must be " + expected);
}

/// A list of that many values.
const toml::array &list_of(const StrictTomlTable &table, const toml::node *found,
                           std::string_view key, std::size_t fewest, std::size_t most,
                           const std::string &expected) {
    const toml::node &node = present(table, found, key, expected);
    const toml::array *array = node.as_array();
    if (array == nullptr || array->size() < fewest || array->size() > most) {
        refuse_value(table, key, node, expected);
    }
    return *array;
}

/// The number of a name; as many as there are if it is none of them.
std::size_t number_of(const toml::node &node, std::span<const std::string_view> names) {
    const auto name = node.value_exact<std::string>();
    const auto found = name ? std::ranges::find(names, *name) : names.end();
    return static_cast<std::size_t>(found - names.begin());
}

} // namespace

StrictTomlTable::StrictTomlTable(std::unique_ptr<Contents> contents)
    : contents_(std::move(contents)) {}
StrictTomlTable::~StrictTomlTable() = default;
StrictTomlTable::StrictTomlTable(StrictTomlTable &&) noexcept = default;
StrictTomlTable &StrictTomlTable::operator=(StrictTomlTable &&) noexcept = default;

StrictTomlTable StrictTomlTable::read(const std::filesystem::path &file) {
    check_input_file(file, "a TOML file", kMaxBytes);
    std::ifstream stream(file, std::ios::binary);
    if (!stream) {
        throw InputError(file.string() + ": cannot be opened; check the name and its permissions");
    }
    return parse({std::istreambuf_iterator<char>(stream), {}}, file);
}

StrictTomlTable StrictTomlTable::parse(const std::string &text, const std::filesystem::path &file) {
    auto contents = std::make_unique<Contents>();
    contents->file = file;
    try {
        contents->root = std::make_shared<toml::table>(toml::parse(text, file.string()));
    } catch (const toml::parse_error &error) {
        throw InputError(file.string() + ":" + std::to_string(error.source().begin.line) +
                         ": is not valid TOML: " + one_line(error.description()));
    }
    contents->table = contents->root.get();
    return StrictTomlTable(std::move(contents));
}

void StrictTomlTable::refuse(std::string_view key, const std::string &problem) const {
    const toml::node *node = contents_->table->get(key);
    const toml::source_position where =
        node != nullptr ? node->source().begin : contents_->table->source().begin;
    const std::string line = where ? ":" + std::to_string(where.line) : "";
    constexpr std::size_t kMax = 2000; // keys and texts of a file may have line breaks
    throw InputError(contents_->file.string() + line + ": " +
                     one_line(contents_->prefix + std::string(key) + " " + problem, kMax));
}

bool StrictTomlTable::has(std::string_view key) const {
    return contents_->table->get(key) != nullptr;
}

bool StrictTomlTable::has_optional(std::string_view key) { return contents_->find(key) != nullptr; }

std::string StrictTomlTable::text(std::string_view key, NumberRange bytes) {
    const toml::node &node = present(*this, contents_->find(key), key, "a text");
    if (!node.is_string()) {
        refuse_value(*this, key, node, "a text");
    }
    std::string text = node.value<std::string>().value_or("");
    const bool is_blank = std::ranges::all_of(text, [](char c) { return c >= 0 && c <= ' '; });
    if ((is_blank && bytes.minimum >= 1.0) || !lies_in(static_cast<double>(text.size()), bytes)) {
        refuse(key, fmt::format("has {} bytes; it must be a text that can be read, of {:g} to {:g}",
                                text.size(), bytes.minimum, bytes.maximum));
    }
    return text;
}

double StrictTomlTable::number(std::string_view key, NumberRange range) {
    const toml::node &node = present(*this, contents_->find(key), key, allowed(range));
    const double value = as_number(node);
    if (!lies_in(value, range)) {
        refuse_value(*this, key, node, allowed(range));
    }
    return value;
}

int StrictTomlTable::integer(std::string_view key, int minimum, int maximum) {
    const double value = number(key, {static_cast<double>(minimum), static_cast<double>(maximum)});
    if (value != std::floor(value)) {
        refuse(key, "is " + plain(value) + "; it must be a whole number");
    }
    return static_cast<int>(value);
}

bool StrictTomlTable::flag(std::string_view key) {
    const toml::node &node = present(*this, contents_->find(key), key, "true or false");
    if (!node.is_boolean()) {
        refuse_value(*this, key, node, "true or false");
    }
    return node.value<bool>().value_or(false);
}

std::size_t StrictTomlTable::choice(std::string_view key, std::span<const std::string_view> names) {
    const toml::node &node = present(*this, contents_->find(key), key, any_of(names));
    const std::size_t number = number_of(node, names);
    if (number == names.size()) {
        const auto name = node.value_exact<std::string>();
        refuse(key, "is " + (name ? '"' + *name + '"' : as_written(node)) + "; it must be " +
                        any_of(names));
    }
    return number;
}

std::vector<std::size_t> StrictTomlTable::choices(std::string_view key,
                                                  std::span<const std::string_view> names) {
    const std::string expected = "a list, each of it " + any_of(names);
    std::vector<std::size_t> chosen;
    for (const toml::node &one :
         list_of(*this, contents_->find(key), key, 0, std::string::npos, expected)) {
        chosen.push_back(number_of(one, names));
        if (chosen.back() == names.size()) {
            refuse(key, "has " + as_written(one) + "; it must be " + expected);
        }
    }
    return chosen;
}

std::vector<double> StrictTomlTable::numbers(std::string_view key, NumberRange range_of_each,
                                             std::size_t most) {
    const std::string expected =
        fmt::format("1 to {} numbers in brackets, each {}", most, allowed(range_of_each));
    std::vector<double> values;
    for (const toml::node &one : list_of(*this, contents_->find(key), key, 1, most, expected)) {
        values.push_back(as_number(one));
        if (!lies_in(values.back(), range_of_each)) {
            refuse(key, "has " + as_written(one) + "; it must be " + expected);
        }
    }
    return values;
}

std::vector<std::string> StrictTomlTable::texts(std::string_view key, std::size_t most) {
    const std::string expected = fmt::format("1 to {} texts in brackets", most);
    const toml::array &array = list_of(*this, contents_->find(key), key, 1, most, expected);
    if (!array.is_homogeneous(toml::node_type::string)) {
        refuse_value(*this, key, array, expected);
    }
    std::vector<std::string> values;
    for (const toml::node &one : array) {
        values.push_back(one.value<std::string>().value_or(""));
    }
    return values;
}

Vector3 StrictTomlTable::vector(std::string_view key, NumberRange range_of_each) {
    const std::string expected = "three numbers in brackets, each " + allowed(range_of_each);
    const toml::array &array = list_of(*this, contents_->find(key), key, 3, 3, expected);
    Vector3 values;
    for (int i = 0; i < 3; ++i) {
        values[i] = as_number(array[static_cast<std::size_t>(i)]);
        if (!lies_in(values[i], range_of_each)) {
            refuse_value(*this, key, array, expected);
        }
    }
    return values;
}

StrictTomlTable StrictTomlTable::table(std::string_view key) {
    const toml::node *node = contents_->find(key);
    if (node == nullptr || !node->is_table()) {
        refuse(key, "is missing; add a table [" + contents_->prefix + std::string(key) + "]");
    }
    auto inner = std::make_unique<Contents>();
    inner->file = contents_->file;
    inner->prefix = contents_->prefix + std::string(key) + ".";
    inner->root = contents_->root;
    inner->table = node->as_table();
    return StrictTomlTable(std::move(inner));
}

int StrictTomlTable::tables(std::string_view key, int count,
                            const std::function<void(int, StrictTomlTable &)> &read_one) {
    const toml::node *node = contents_->find(key);
    if (node == nullptr || !node->is_array_of_tables()) {
        StrictTomlTable only = table(key);
        read_one(0, only);
        return 1;
    }
    const std::size_t there = node->as_array()->size();
    if (there != static_cast<std::size_t>(count)) {
        refuse(key, "appears " + std::to_string(there) + " times; it must appear once or " +
                        std::to_string(count) + " times");
    }
    for (int i = 0; i < count; ++i) {
        StrictTomlTable one = row(key, static_cast<std::size_t>(i));
        read_one(i, one);
    }
    return count;
}

void StrictTomlTable::rows(std::string_view key, std::size_t most,
                           const std::function<void(StrictTomlTable &)> &read_one) {
    const toml::node *node = contents_->find(key);
    if (node == nullptr || !node->is_array_of_tables()) {
        refuse(key, "is missing; add a table [[" + contents_->prefix + std::string(key) + "]]");
    }
    const std::size_t there = node->as_array()->size();
    if (there > most) {
        refuse(key, fmt::format("appears {} times; it must appear 1 to {} times", there, most));
    }
    for (std::size_t i = 0; i < there; ++i) {
        StrictTomlTable one = row(key, i);
        read_one(one);
    }
}

/// One of the tables [[key]]. @pre it is there
StrictTomlTable StrictTomlTable::row(std::string_view key, std::size_t index) const {
    auto inner = std::make_unique<Contents>();
    inner->file = contents_->file;
    inner->prefix = contents_->prefix + std::string(key) + "[" + std::to_string(index + 1) + "].";
    inner->root = contents_->root;
    inner->table = (*contents_->table->get_as<toml::array>(key))[index].as_table();
    return StrictTomlTable(std::move(inner));
}

void StrictTomlTable::refuse_unknown_keys() const {
    for (const auto &[key, node] : *contents_->table) {
        if (!contents_->requested.contains(key.str())) {
            std::vector<std::string_view> known(contents_->requested.begin(),
                                                contents_->requested.end());
            std::string list;
            for (const std::string_view name : known) {
                list += (list.empty() ? "" : ", ") + std::string(name);
            }
            sort_by_similarity(known, key.str(), [](std::string_view name) { return name; });
            refuse(key.str(),
                   "is not known" +
                       (known.empty() ? "" : "; the nearest is " + std::string(known[0])) +
                       "; the known keys are " + list);
        }
    }
}

} // namespace springdrive
