#include "app/doctor/usb_boards.h"

#include "base/number_in.h"
#include "device/usb/protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

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

bool has_its_numbers(const Machine &machine, const std::string &name) {
    return machine.text(kDevices + name + "/idVendor") == fmt::format("{:04x}", usb::kVendorId) &&
           machine.text(kDevices + name + "/idProduct") == fmt::format("{:04x}", usb::kProductId);
}

/// Whether an interface of this device, "1-2:1.0" of "1-2", is the protocol's, of any version.
bool has_its_interface(const Machine &machine, const std::string &name) {
    return std::ranges::any_of(machine.names_in(kDevices), [&](const std::string &other) {
        return other.starts_with(name + ":") &&
               machine.text(kDevices + other + "/bInterfaceClass") ==
                   fmt::format("{:02x}", usb::kInterfaceClass) &&
               machine.text(kDevices + other + "/bInterfaceSubClass") ==
                   fmt::format("{:02x}", usb::kInterfaceSubclass);
    });
}

} // namespace

std::string udev_rule() {
    return fmt::format("SUBSYSTEM==\"usb\", ENV{{DEVTYPE}}==\"usb_device\", "
                       "ATTR{{idVendor}}==\"{:04x}\", ATTR{{idProduct}}==\"{:04x}\", "
                       "ENV{{ID_USB_INTERFACES}}==\"*:{:02x}{:02x}??:*\", TAG+=\"uaccess\"",
                       usb::kVendorId, usb::kProductId, usb::kInterfaceClass,
                       usb::kInterfaceSubclass);
}

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

std::vector<Board> boards_of(const Machine &machine, const UsbProbe &probe) {
    std::vector<Board> boards;
    for (const usb::SurveyedBoard &board : probe.boards) {
        boards.push_back({board});
    }
    if (!boards.empty()) {
        return boards;
    }
    for (const std::string &name : machine.names_in(kDevices)) {
        if (has_its_numbers(machine, name) && has_its_interface(machine, name)) {
            boards.push_back(board_of_kernel(machine, name, probe.has_answered));
        }
    }
    return boards;
}

std::vector<std::string> others_with_its_numbers(const Machine &machine) {
    std::vector<std::string> others;
    std::ranges::copy_if(
        machine.names_in(kDevices), std::back_inserter(others), [&](const std::string &name) {
            return has_its_numbers(machine, name) && !has_its_interface(machine, name);
        });
    return others;
}

std::optional<UsingProcess> user_of(const Machine &machine, const Board &board) {
    for (const std::string &process : machine.names_in("/proc")) {
        const auto id = number_in<std::int64_t>(process);
        if (!id) {
            continue;
        }
        const std::string folder = "/proc/" + process;
        for (const std::string &file : machine.names_in(folder + "/fd")) {
            if (machine.target_of(folder + "/fd/" + file) == board.node()) {
                return UsingProcess{*id, machine.text(folder + "/comm").value_or("a program")};
            }
        }
    }
    return std::nullopt;
}

} // namespace springdrive::app::doctor
