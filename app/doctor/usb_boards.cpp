#include "app/doctor/usb_boards.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace springdrive::app::doctor {

namespace {

constexpr const char *kDevices = "/sys/bus/usb/devices/";

/// Three digits at most, as in the node's name; 0 for anything else.
int number_of_node(const Machine &machine, const std::string &file) {
    const std::int64_t number = machine.number(file).value_or(0);
    return number >= 0 && number <= 999 ? static_cast<int>(number) : 0;
}

/// Where libusb has no board, or no answer, the kernel's list tells why.
Board board_of_kernel(const Machine &machine, const std::string &name, bool has_answered) {
    const std::string folder = kDevices + name;
    Board board;
    board.bus = number_of_node(machine, folder + "/busnum");
    board.address = number_of_node(machine, folder + "/devnum");
    board.sysfs_name = name;
    board.serial = machine.text(folder + "/serial").value_or("");
    board.obstacle =
        has_answered ? usb::BoardObstacle::no_permission : usb::BoardObstacle::no_answer;
    board.problem = "does not answer";
    return board;
}

} // namespace

std::string Board::name() const {
    return serial.empty() ? fmt::format("the board at {}", sysfs_name) : "board " + serial;
}

std::string Board::node() const { return fmt::format("/dev/bus/usb/{:03}/{:03}", bus, address); }

std::vector<std::string> Board::hubs() const {
    std::vector<std::string> hubs;
    for (std::size_t point = sysfs_name.find('.'); point != std::string::npos;
         point = sysfs_name.find('.', point + 1)) {
        hubs.push_back(sysfs_name.substr(0, point));
    }
    return hubs;
}

std::vector<Board> boards_of(const Machine &machine, const UsbTrial &trial) {
    std::vector<Board> boards;
    for (const usb::SurveyedBoard &board : trial.boards) {
        boards.push_back({board});
    }
    if (!boards.empty()) {
        return boards;
    }
    for (const std::string &name : machine.names_in(kDevices)) {
        const std::string folder = kDevices + name;
        if (machine.text(folder + "/idVendor") == "1209" &&
            machine.text(folder + "/idProduct") == "0001") {
            boards.push_back(board_of_kernel(machine, name, trial.has_answered));
        }
    }
    return boards;
}

std::optional<UsingProcess> user_of(const Machine &machine, const Board &board) {
    for (const std::string &process : machine.names_in("/proc")) {
        std::int64_t id = 0;
        const char *const end = process.data() + process.size();
        if (const auto [rest, error] = std::from_chars(process.data(), end, id);
            error != std::errc() || rest != end) {
            continue;
        }
        const std::string folder = "/proc/" + process;
        for (const std::string &file : machine.names_in(folder + "/fd")) {
            if (machine.target_of(folder + "/fd/" + file) == board.node()) {
                return UsingProcess{id, machine.text(folder + "/comm").value_or("a program")};
            }
        }
    }
    return std::nullopt;
}

} // namespace springdrive::app::doctor
