#include "base/table.h"

#include "base/assertions.h"
#include "base/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ostream>

namespace springdrive {

namespace {

using Line = std::vector<std::string>;

/// `cell` of each column's name, then of each row.
template <typename Quoted>
void write_lines(std::ostream &out, const Table &table, char separator, Quoted cell) {
    std::string line;
    for (const Column &column : table.columns) {
        line += cell(column.name) + separator;
    }
    line.back() = '\n';
    out << line;
    for (const std::vector<Cell> &row : table.rows) {
        SPRINGDRIVE_ASSERT(row.size() == table.columns.size());
        line.clear();
        for (std::size_t i = 0; i < row.size(); ++i) {
            line += cell(row[i].text(table.columns[i].format)) + separator;
        }
        line.back() = '\n';
        out << line;
    }
}

/// For each column whether it has numbers, which are aligned at the right.
std::vector<bool> right_columns(const Table &table) {
    std::vector<bool> right;
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
        right.push_back(
            !table.columns[i].format.empty() ||
            std::ranges::any_of(table.rows, [i](const auto &row) { return row[i].is_number(); }));
    }
    return right;
}

/// The cells of a row as people see them.
Line shown(const Table &table, const std::vector<Cell> &row) {
    SPRINGDRIVE_ASSERT(row.size() == table.columns.size());
    Line line;
    for (std::size_t i = 0; i < row.size(); ++i) {
        line.push_back(row[i].is_empty() ? "–" : row[i].text(table.columns[i].format));
    }
    return line;
}

/// The headings' lines, the last of each beside one another.
std::vector<Line> heading_lines(const Table &table) {
    const auto count = [](const Column &column) { return std::ranges::count(column.name, '\n'); };
    const auto height = std::ranges::max(table.columns, {}, count).name;
    std::vector<Line> lines(1 + static_cast<std::size_t>(std::ranges::count(height, '\n')));
    for (const Column &column : table.columns) {
        std::string_view rest = column.name;
        for (std::size_t from_below = 1; from_below <= lines.size(); ++from_below) {
            const std::size_t before = rest.rfind('\n');
            const bool is_last = before == std::string_view::npos;
            lines[lines.size() - from_below].emplace_back(is_last ? rest : rest.substr(before + 1));
            rest = is_last ? "" : rest.substr(0, before);
        }
    }
    return lines;
}

/// In characters, not bytes.
std::size_t width_of(std::string_view text) {
    return static_cast<std::size_t>(
        std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

} // namespace

Cell Cell::like_number(std::string text) {
    Cell cell(std::move(text));
    cell.kind_ = Kind::whole;
    return cell;
}

bool Cell::is_empty() const {
    return kind_ == Kind::none || (kind_ == Kind::real && !std::isfinite(number_));
}

std::string Cell::text(std::string_view format) const {
    if (kind_ != Kind::real) {
        return text_;
    }
    return is_empty() ? "" : fmt::format(fmt::runtime(fmt::format("{{:{}}}", format)), number_);
}

Table Table::with_columns(std::string_view columns, std::string_view format) {
    Table table;
    for (std::size_t at = 0; at <= columns.size();) {
        const std::size_t end = std::min(columns.find(',', at), columns.size());
        const std::string_view column = columns.substr(at, end - at);
        const std::size_t colon = column.find(':');
        const bool has_own = colon != std::string_view::npos;
        table.columns.push_back({std::string(column.substr(0, colon)),
                                 std::string(has_own ? column.substr(colon + 1) : format)});
        at = end + 1;
    }
    return table;
}

void write_csv(std::ostream &out, const Table &table) {
    write_lines(out, table, ',', [](const std::string &text) { return csv_cell(text); });
}

void write_tsv(std::ostream &out, const Table &table) { write_lines(out, table, '\t', tsv_cell); }

void write_text(std::ostream &out, const Table &table) {
    std::vector<Line> lines = heading_lines(table);
    for (const std::vector<Cell> &row : table.rows) {
        lines.push_back(shown(table, row));
    }
    std::vector<std::size_t> widths(table.columns.size());
    for (const Line &line : lines) {
        for (std::size_t i = 0; i < line.size(); ++i) {
            widths[i] = std::max(widths[i], width_of(line[i]));
        }
    }
    const std::vector<bool> right = right_columns(table);
    for (const Line &line : lines) {
        std::string text;
        for (std::size_t i = 0; i < line.size(); ++i) {
            const std::string blanks(widths[i] - width_of(line[i]), ' ');
            text += (i > 0 ? "  " : "") + (right[i] ? blanks + line[i] : line[i] + blanks);
        }
        out << text.substr(0, text.find_last_not_of(' ') + 1) << '\n';
    }
}

void write_markdown(std::ostream &out, const Table &table) {
    const auto write_line = [&out](const Line &cells) {
        for (const std::string &cell : cells) {
            out << "| ";
            for (const char c : cell) {
                out << (c == '|' ? "\\" : "") << c;
            }
            out << ' ';
        }
        out << "|\n";
    };
    Line names;
    Line rules;
    for (const bool is_right : right_columns(table)) {
        names.push_back(table.columns[names.size()].name);
        rules.emplace_back(is_right ? "---:" : "---");
    }
    write_line(names);
    write_line(rules);
    for (const std::vector<Cell> &row : table.rows) {
        write_line(shown(table, row));
    }
}

} // namespace springdrive
