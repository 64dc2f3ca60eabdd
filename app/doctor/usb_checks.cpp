// What stands between springdrive and a board on USB.
#include "app/doctor/checks.h"

#include "base/text.h"
#include "device/usb/protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <string>

namespace springdrive::app::doctor {

namespace {

using usb::BoardObstacle;

constexpr const char *kDevices = "/sys/bus/usb/devices/";

/// A board, by what libusb and what the kernel say.
struct Board : usb::SurveyedBoard {
    /// Its serial number, or where it is.
    [[nodiscard]] std::string name() const {
        return serial.empty() ? fmt::format("the board at {}", sysfs_name) : "board " + serial;
    }
    [[nodiscard]] std::string node() const {
        return fmt::format("/dev/bus/usb/{:03}/{:03}", bus, address);
    }
    [[nodiscard]] std::string sysfs_folder() const { return kDevices + sysfs_name; }

    /// The hubs between it and the computer, in sysfs: "1-2" before "1-2.3".
    [[nodiscard]] std::vector<std::string> hubs() const {
        std::vector<std::string> hubs;
        for (std::size_t point = sysfs_name.find('.'); point != std::string::npos;
             point = sysfs_name.find('.', point + 1)) {
            hubs.push_back(sysfs_name.substr(0, point));
        }
        return hubs;
    }
};

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

struct UsingProcess {
    std::int64_t id = 0;
    std::string name;
};

/// Those that libusb found. If none, those that the kernel has: libusb sees no board without its
/// device node.
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

/// The devices that have a board's numbers, which are for tests, but not its interface.
std::vector<std::string> others_with_its_numbers(const Machine &machine) {
    std::vector<std::string> others;
    std::ranges::copy_if(
        machine.names_in(kDevices), std::back_inserter(others), [&](const std::string &name) {
            return has_its_numbers(machine, name) && !has_its_interface(machine, name);
        });
    return others;
}

/// The process that has the board's node open, as far as this user may see.
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

constexpr double kFullSpeedMost_hz = 1000.0;

constexpr const char *kContainerLine = "start the container with -v /dev/bus/usb:/dev/bus/usb "
                                       "--device-cgroup-rule 'c 189:* rmw'";

Finding absent(const Evidence &evidence) {
    const Machine &machine = evidence.machine;
    const std::string &problem = evidence.probes.usb.problem;
    std::string found =
        fmt::format("none is connected (vendor {:04x}, product {:04x}, interface {:02x}/{:02x}){}",
                    usb::kVendorId, usb::kProductId, usb::kInterfaceClass, usb::kInterfaceSubclass,
                    problem.empty() ? "" : "; " + problem);
    for (const std::string &name : others_with_its_numbers(machine)) {
        found += fmt::format("; {} has these numbers, but not the interface: another product, "
                             "or a board without its firmware",
                             name);
    }
    if (!evidence.purpose.uses_usb) {
        return {Verdict::not_applicable, found + "; not needed by --device sim"};
    }
    return {Verdict::failure, found,
            machine.exists("/dev/bus/usb")
                ? "plug the board in and switch its power on, then see: springdrive device list"
            : machine.is_container() ? kContainerLine
                                     : "use a computer that has USB: this one has no /dev/bus/usb"};
}

std::string list_of(const std::vector<Board> &boards) {
    std::string list;
    for (const Board &board : boards) {
        list += (list.empty() ? "" : ", ") + board.name();
    }
    return list;
}

Finding presence(const Evidence &evidence, const std::vector<Board> &all,
                 const std::vector<Board> &meant) {
    const Purpose &purpose = evidence.purpose;
    if (meant.size() == 1 || (!meant.empty() && !purpose.uses_usb)) {
        return {Verdict::ok, list_of(all)};
    }
    return {Verdict::failure,
            meant.empty() ? fmt::format("none has the serial number {}, but {} is there",
                                        purpose.serial, list_of(all))
                          : fmt::format("{}: {}", meant.size(), list_of(all)),
            "springdrive --device usb:" + shell_word(all.front().serial)};
}

bool has_rule(const Machine &machine) {
    for (const char *const folder : {"/etc/udev/rules.d/", "/run/udev/rules.d/",
                                     "/usr/lib/udev/rules.d/", "/lib/udev/rules.d/"}) {
        for (const std::string &name : machine.names_in(folder)) {
            const auto is_ours = [](const std::string &line) {
                return !line.starts_with("#") &&
                       line.find(fmt::format("\"{:04x}\"", usb::kVendorId)) != std::string::npos;
            };
            if (name.find("springdrive") != std::string::npos &&
                std::ranges::any_of(machine.lines(folder + name), is_ours)) {
                return true;
            }
        }
    }
    return false;
}

std::string install_rule(const Process &process) {
    const std::filesystem::path file = process.setup_folder / "70-springdrive-usb.rules";
    std::error_code unreadable;
    return std::filesystem::is_regular_file(file, unreadable)
               ? fmt::format("{}cp {} /etc/udev/rules.d/", process.sudo(),
                             shell_word(file.string()))
               : fmt::format("echo '{}' | {}tee /etc/udev/rules.d/70-springdrive-usb.rules",
                             udev_rule(), process.sudo());
}

std::string permit(const Evidence &evidence, const Board &board) {
    const Process &process = evidence.process;
    if (evidence.machine.is_container()) {
        return kContainerLine;
    }
    if (!has_rule(evidence.machine)) {
        return install_rule(process) +
               fmt::format(" && {0}udevadm control --reload && {0}udevadm trigger "
                           "--attr-match=idVendor={1:04x}",
                           process.sudo(), usb::kVendorId);
    }
    // The rule is for the person at the screen.
    return process.variable("SSH_CONNECTION").empty()
               ? "unplug the board and plug it in again: the rule for it is installed"
               : fmt::format("{}chown \"$USER\" {}", process.sudo(), board.node());
}

/// Where the kernel has the board, but this system no node for it.
Finding no_node(const Evidence &evidence, const Board &board) {
    return {evidence.purpose.worse_with_usb(),
            fmt::format("{} is missing, though the kernel has the board at {}", board.node(),
                        board.sysfs_name),
            evidence.machine.is_container()
                ? kContainerLine
                : fmt::format("{0}mkdir -p {1} && {0}mknod -m 666 {2} c 189 {3}",
                              evidence.process.sudo(),
                              board.node().substr(0, board.node().rfind('/')), board.node(),
                              128 * (board.bus - 1) + board.address - 1)};
}

Finding permission(const Evidence &evidence, const Board &board) {
    const Verdict wrong = evidence.purpose.worse_with_usb();
    const std::string node = board.node();
    if (!evidence.machine.exists(node) && board.obstacle != BoardObstacle::none) {
        return no_node(evidence, board);
    }
    if (board.obstacle == BoardObstacle::no_permission) {
        return {wrong, node + " may not be written to", permit(evidence, board)};
    }
    if (board.obstacle != BoardObstacle::in_use) {
        return {Verdict::ok, node + " may be used"};
    }
    const std::optional<UsingProcess> other = user_of(evidence.machine, board);
    if (!other) {
        return {wrong, node + " is used by another program",
                evidence.process.sudo() + "fuser -v " + node + "  # names the program to end"};
    }
    if (other->id == evidence.process.parent_id) { // the window that asks
        return {Verdict::ok, fmt::format("{} is used by the {} that asks", node, other->name)};
    }
    return {wrong, fmt::format("{} is used by {}, process {}", node, other->name, other->id),
            fmt::format("kill {}", other->id)};
}

/// Whether only the board itself can stand in the way of an answer.
bool may_be_asked(const Evidence &evidence, const Board &board) {
    return board.obstacle != BoardObstacle::no_permission &&
           board.obstacle != BoardObstacle::in_use && evidence.machine.exists(board.node());
}

Finding firmware(const Evidence &evidence, const Board &board) {
    if (board.obstacle == BoardObstacle::none) {
        return {Verdict::ok, board.firmware};
    }
    if (!may_be_asked(evidence, board)) {
        return {Verdict::not_applicable, "cannot be asked"};
    }
    return {evidence.purpose.worse_with_usb(),
            board.firmware + (board.firmware.empty() ? "" : ": ") + board.problem,
            board.obstacle == BoardObstacle::no_answer
                ? "unplug the board, switch its power off and on, and plug it in again"
                : "install the firmware of this version of springdrive: docs/board.md"};
}

Finding speed(const Evidence &evidence, const Board &board) {
    const auto megabits = evidence.machine.text(board.sysfs_folder() + "/speed");
    const std::string found = megabits ? *megabits + " Mbit/s" : board.speed;
    const bool is_slow = megabits
                             ? *megabits == "12" || *megabits == "1.5"
                             : board.speed.starts_with("full") || board.speed.starts_with("low");
    if (!is_slow) {
        return {Verdict::ok, found};
    }
    const bool asks_too_much = evidence.purpose.servo_hz > kFullSpeedMost_hz;
    const bool is_too_slow = asks_too_much || found.find("1.5") != std::string::npos;
    return {is_too_slow ? evidence.purpose.worse_with_usb() : Verdict::warning,
            found + ", full speed or less, instead of 480",
            asks_too_much ? "springdrive --device usb --servo-hz 1000"
                          : "plug the board into another port, without a hub, by another cable"};
}

Finding autosuspend(const Evidence &evidence, const Board &board) {
    const std::string folder = board.sysfs_folder() + "/power";
    const auto control = evidence.machine.text(folder + "/control");
    if (!control) {
        return {Verdict::not_applicable, "not to be seen here"};
    }
    if (*control != "auto") {
        return {Verdict::ok, "control is " + *control};
    }
    const auto delay_ms = evidence.machine.number(folder + "/autosuspend_delay_ms");
    return {Verdict::warning,
            fmt::format("control is auto: suspended {} unused",
                        delay_ms ? fmt::format("after {} ms", *delay_ms) : "while"),
            fmt::format("echo on | {}tee {}/control", evidence.process.sudo(), folder)};
}

Finding hub(const Evidence &evidence, const Board &board) {
    const std::vector<std::string> hubs = board.hubs();
    if (hubs.empty()) {
        return {Verdict::ok, fmt::format("none: {} is a port of the computer", board.sysfs_name)};
    }
    std::string found = fmt::format("{} at {}", hubs.size(), board.sysfs_name);
    for (const std::string &name : hubs) {
        const auto product = evidence.machine.text(kDevices + name + "/product");
        found += fmt::format("; {}: {}", name, product.value_or("a hub"));
    }
    return {Verdict::warning, found,
            "plug the board into the computer itself (one hub may be built into it)"};
}

struct BoardRow {
    const char *id = "";
    const char *title = ""; ///< before the board's name
    const char *matters = "";
    Finding (*judge)(const Evidence &, const Board &) = nullptr;
};
constexpr std::array<BoardRow, 5> kOfEachBoard{{
    {"usb_permission", "permission for ", "a program may use a board only with it", permission},
    {"usb_firmware", "firmware of ", "program and firmware must know the same protocol", firmware},
    {"usb_speed", "speed of ", "full speed allows a servo of 1000 Hz", speed},
    {"usb_autosuspend", "autosuspend of ",
     "a board that was suspended has to be woken before it answers", autosuspend},
    {"usb_hub", "hubs before ", "a hub delays each packet, and shares its line among its devices",
     hub},
}};

} // namespace

std::string udev_rule() {
    return fmt::format("SUBSYSTEM==\"usb\", ENV{{DEVTYPE}}==\"usb_device\", "
                       "ATTR{{idVendor}}==\"{:04x}\", ATTR{{idProduct}}==\"{:04x}\", "
                       "ENV{{ID_USB_INTERFACES}}==\"*:{:02x}{:02x}??:*\", TAG+=\"uaccess\"",
                       usb::kVendorId, usb::kProductId, usb::kInterfaceClass,
                       usb::kInterfaceSubclass);
}

std::vector<Check> usb_checks(const Evidence &evidence) {
    const UsbProbe &probe = evidence.probes.usb;
    const std::vector<Board> all = boards_of(evidence.machine, probe);
    std::vector<Board> meant;
    std::ranges::copy_if(all, std::back_inserter(meant), [&](const Board &board) {
        return evidence.purpose.serial.empty() || board.serial == evidence.purpose.serial;
    });
    std::vector<Check> checks{
        {!all.empty() ? presence(evidence, all, meant)
         : probe.has_answered
             ? absent(evidence)
             : Finding{evidence.purpose.worse_with_usb(), "USB gave no answer in time",
                       "unplug what hangs on USB, and repeat springdrive "
                       "doctor"},
         "usb_board", "board on USB", "springdrive --device usb drives it"}};
    for (const Board &board : meant) {
        for (const BoardRow &row : kOfEachBoard) {
            checks.push_back(
                {row.judge(evidence, board), row.id, row.title + board.name(), row.matters});
        }
    }
    return checks;
}

} // namespace springdrive::app::doctor
