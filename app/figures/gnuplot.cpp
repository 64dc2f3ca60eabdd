#include "app/figures/gnuplot.h"

#include "app/host/folders.h"
#include "app/host/process.h"
#include "base/input_error.h"
#include "base/text.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <list>
#include <sys/wait.h>
#include <utility>

namespace springdrive::app {

namespace {

/// The last line that is not empty.
std::string last_line(const std::string &text) {
    const std::size_t last = text.find_last_not_of(" \n\r\t");
    if (last == std::string::npos) {
        return "no message";
    }
    const std::size_t before = text.find_last_of('\n', last);
    const std::size_t first = text.find_first_not_of(" \t", before + 1);
    return text.substr(first, last + 1 - first);
}

bool is_whole(const std::filesystem::path &svg) {
    std::ifstream file(svg, std::ios::binary);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    constexpr std::string_view kEnd = "</svg>";
    const std::size_t end = text.find_last_not_of(" \n");
    return end != std::string::npos && end + 1 >= kEnd.size() &&
           text.compare(end + 1 - kEnd.size(), kEnd.size(), kEnd) == 0;
}

/// A CSV file without what is in quotes: gnuplot does not know doubled quotes, so that a name could
/// change which cells it reads.
std::string without_quoted(const std::filesystem::path &csv) {
    std::ifstream from(csv, std::ios::binary);
    std::string text;
    bool is_quoted = false;
    for (char c = 0; from.get(c);) {
        is_quoted = is_quoted != (c == '"');
        if (!is_quoted && c != '"') {
            text += c;
        }
    }
    if (!from.eof()) {
        throw InputError(csv.string() + ": cannot be read for gnuplot; check its permissions");
    }
    return text;
}

} // namespace

void ChartMarks::add(std::string_view name, double number) {
    assignments_ += fmt::format("{} = {:.17g}\n", name, number);
}

void ChartMarks::add(std::string_view name, std::string_view text) {
    assignments_ += fmt::format("{} = {}\n", name, gnuplot_string(text));
}

void ChartMarks::add(std::string_view name, const std::vector<std::vector<double>> &rows) {
    assignments_ += fmt::format("${} << end\n", name);
    for (const std::vector<double> &row : rows) {
        assignments_ += fmt::format("{:.17g}\n", fmt::join(row, ","));
    }
    assignments_ += "end\n";
}

Chart chart_of(std::string_view script, const ChartMarks &marks,
               const std::filesystem::path &folder, std::string csv, std::string svg,
               std::string second_csv) {
    return {asset_folder() / "figures" / fmt::format("{}.gnuplot", script),
            marks.assignments(),
            folder,
            std::move(csv),
            std::move(svg),
            std::move(second_csv)};
}

void draw(const Chart &chart, FilePolicy policy) {
    const std::filesystem::path svg = chart.folder / chart.svg;
    NewFile drawn(svg, policy.readers);
    // gnuplot runs where it draws and is given names of our own only: it takes some that begin with
    // < or | for commands, and no line end. All else is in a file: an argument has a limit.
    const std::filesystem::path folder = drawn.temporary().parent_path();
    std::list<NewFile> copies; // gone at the end
    const auto copied = [&](const std::string &text) {
        const std::filesystem::path &copy = copies.emplace_back(svg, policy.readers).temporary();
        std::ofstream file(copy, std::ios::binary);
        if (!file.write(text.data(), std::ssize(text)).flush()) {
            throw InputError(svg.string() + ": cannot be drawn: no room for gnuplot's copy of the "
                                            "numbers; is the disk full?");
        }
        return copy.filename().string();
    };
    std::string marks =
        fmt::format("svg = '{}'\n{}", drawn.temporary().filename().string(), chart.assignments);
    for (const auto &[variable, name] :
         {std::pair("csv", &chart.csv), std::pair("second_csv", &chart.second_csv)}) {
        if (!name->empty()) {
            marks +=
                fmt::format("{} = '{}'\n", variable, copied(without_quoted(chart.folder / *name)));
        }
    }
    // -d: ignore the user's gnuplot settings.
    const std::filesystem::path script = std::filesystem::absolute(chart.script);
    const ProgramEnding ending = run_program(
        {"gnuplot", "-d", copied(marks), script.parent_path() / "style.gnuplot", script}, folder,
        ProgramStream::error);
    if (ending.spawn_error == ENOENT) {
        throw InputError("gnuplot is not installed; install the package gnuplot-nox (the figures' "
                         "numbers are in " +
                         chart.folder.string() + ", as CSV files)");
    }
    if (ending.spawn_error != 0) {
        throw InputError(
            "gnuplot cannot be started: " +
            std::string(std::strerror(ending.spawn_error))); // NOLINT(concurrency-mt-unsafe)
    }
    if (!WIFEXITED(ending.wait_status) || WEXITSTATUS(ending.wait_status) != 0) {
        throw InputError(svg.string() + ": gnuplot could not draw it: " + last_line(ending.text));
    }
    if (!is_whole(drawn.temporary())) {
        throw InputError(svg.string() + ": gnuplot did not write it completely; is the disk full, "
                                        "or gnuplot built without SVG?");
    }
    drawn.publish(policy.existing);
}

std::filesystem::path numbers_of(std::filesystem::path svg) {
    return svg.replace_extension(".csv");
}

void draw_numbers(const std::filesystem::path &svg, std::string_view script,
                  const ChartMarks &marks, FilePolicy policy) {
    draw(chart_of(script, marks, svg.parent_path().empty() ? "." : svg.parent_path(),
                  numbers_of(svg).filename().string(), svg.filename().string()),
         policy);
}

} // namespace springdrive::app
