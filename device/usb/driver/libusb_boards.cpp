#include "device/usb/driver/libusb_boards.h"

#include "base/input_error.h"
#include "base/text.h"
#include "device/usb/driver/board_request.h"
#include "device/usb/driver/board_survey.h"
#include "device/usb/protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace springdrive::usb {

namespace {

class DeviceList {
public:
    explicit DeviceList(libusb_context *context)
        : count_(libusb_get_device_list(context, &devices_)) {}
    ~DeviceList() {
        if (devices_ != nullptr) {
            libusb_free_device_list(devices_, 1);
        }
    }
    DeviceList(const DeviceList &) = delete;
    DeviceList &operator=(const DeviceList &) = delete;

    [[nodiscard]] std::span<libusb_device *> all() const {
        return {devices_, count_ > 0 ? static_cast<std::size_t>(count_) : 0U};
    }

private:
    libusb_device **devices_ = nullptr;
    ssize_t count_;
};

std::string place_of(libusb_device *device) {
    return fmt::format("bus {} device {}", libusb_get_bus_number(device),
                       libusb_get_device_address(device));
}

std::optional<Endpoints> endpoints_in(const libusb_interface_descriptor &description) {
    if (description.bInterfaceClass != kInterfaceClass ||
        description.bInterfaceSubClass != kInterfaceSubclass) {
        return std::nullopt;
    }
    Endpoints found{description.bInterfaceNumber, description.bInterfaceProtocol, 0, 0};
    for (const libusb_endpoint_descriptor &endpoint :
         std::span(description.endpoint, description.bNumEndpoints)) {
        if ((endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) != LIBUSB_TRANSFER_TYPE_INTERRUPT) {
            continue;
        }
        const bool is_in = (endpoint.bEndpointAddress & LIBUSB_ENDPOINT_DIR_MASK) != 0;
        (is_in ? found.in : found.out) = endpoint.bEndpointAddress;
    }
    return found.in != 0 && found.out != 0 ? std::optional(found) : std::nullopt;
}

std::optional<Endpoints> endpoints_of(libusb_device *device) {
    libusb_config_descriptor *raw = nullptr;
    if (libusb_get_active_config_descriptor(device, &raw) != 0) {
        return std::nullopt;
    }
    const std::unique_ptr<libusb_config_descriptor, decltype(&libusb_free_config_descriptor)>
        configuration(raw, &libusb_free_config_descriptor);
    for (const libusb_interface &one :
         std::span(configuration->interface, configuration->bNumInterfaces)) {
        if (one.num_altsetting > 0) {
            if (const auto found = endpoints_in(one.altsetting[0])) {
                return found;
            }
        }
    }
    return std::nullopt;
}

/// A board that is connected; the numbers alone, which are for tests, are other products', too.
struct Connected {
    libusb_device *device = nullptr;
    Endpoints endpoints;
    std::uint8_t serial_index = 0; ///< of its string
};

struct ConnectedBoards {
    std::vector<Connected> boards;
    std::string others; ///< places of devices that have a board's numbers only
};

ConnectedBoards connected_in(const DeviceList &devices) {
    ConnectedBoards found;
    for (libusb_device *device : devices.all()) {
        libusb_device_descriptor description{};
        if (libusb_get_device_descriptor(device, &description) != 0 ||
            description.idVendor != kVendorId || description.idProduct != kProductId) {
            continue;
        }
        if (const auto endpoints = endpoints_of(device)) {
            found.boards.push_back({device, *endpoints, description.iSerialNumber});
        } else {
            found.others += (found.others.empty() ? "" : ", ") + place_of(device);
        }
    }
    return found;
}

std::string serial_of(libusb_device_handle *handle, std::uint8_t index) {
    std::array<unsigned char, 64> text{};
    const int size = libusb_get_string_descriptor_ascii(handle, index, text.data(),
                                                        static_cast<int>(text.size()));
    return size > 0 ? one_line({reinterpret_cast<const char *>(text.data()), // of any origin
                                static_cast<std::size_t>(size)})
                    : std::string();
}

std::vector<OpenedBoard> open_all(const ConnectedBoards &connected) {
    std::vector<OpenedBoard> boards;
    for (const Connected &one : connected.boards) {
        libusb_device_handle *raw = nullptr;
        const int error = libusb_open(one.device, &raw);
        OpenedBoard &board = boards.emplace_back();
        board.place = place_of(one.device);
        board.endpoints = one.endpoints;
        board.handle.reset(raw);
        if (error != 0) {
            board.problem = advice_on(error);
        } else {
            board.serial = serial_of(raw, one.serial_index);
        }
    }
    return boards;
}

std::string list_of(const std::vector<OpenedBoard> &boards) {
    std::string list;
    for (const OpenedBoard &board : boards) {
        list += (list.empty() ? "" : ", ") + (board.serial.empty() ? board.place : board.serial);
    }
    return list;
}

BoardObstacle obstacle_of(int error) {
    switch (error) {
    case 0:
        return BoardObstacle::none;
    case LIBUSB_ERROR_ACCESS:
        return BoardObstacle::no_permission;
    case LIBUSB_ERROR_BUSY:
        return BoardObstacle::in_use;
    default:
        return BoardObstacle::no_answer;
    }
}

/// @return an error of libusb
int ask_for_identity(libusb_device_handle *handle, const Endpoints &endpoints,
                     SurveyedBoard &board) {
    if (const int error = libusb_claim_interface(handle, endpoints.interface_number); error != 0) {
        return error;
    }
    std::array<std::uint8_t, kIdentitySize> answer{};
    const int size = libusb_control_transfer(
        handle, kRequestIn, static_cast<std::uint8_t>(Kind::identity), 0,
        static_cast<std::uint16_t>(endpoints.interface_number), answer.data(),
        static_cast<std::uint16_t>(answer.size()), kControlTimeout_ms);
    libusb_release_interface(handle, endpoints.interface_number);
    if (size < 0 && size != LIBUSB_ERROR_PIPE) {
        return size;
    }
    take_identity(std::span(answer).first(size > 0 ? static_cast<std::size_t>(size) : 0U), board);
    return 0;
}

/// @return an error of libusb
int survey(const Connected &connected, SurveyedBoard &board) {
    libusb_device *const device = connected.device;
    std::array<std::uint8_t, 7> ports{}; // the deepest that USB allows
    const int depth = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
    board.bus = libusb_get_bus_number(device);
    board.address = libusb_get_device_address(device);
    board.sysfs_name = sysfs_name_of(
        board.bus, std::span(ports).first(depth > 0 ? static_cast<std::size_t>(depth) : 0U));
    board.speed = name_of_speed(libusb_get_device_speed(device));
    libusb_device_handle *raw = nullptr;
    if (const int error = libusb_open(device, &raw); error != 0) {
        return error;
    }
    const Handle handle(raw);
    board.serial = serial_of(raw, connected.serial_index);
    return ask_for_identity(raw, connected.endpoints, board);
}

} // namespace

Context make_context() {
    libusb_context *context = nullptr;
    if (const int error = libusb_init(&context); error != 0) {
        throw InputError(
            fmt::format("USB cannot be used: {}; is /dev/bus/usb there?", libusb_strerror(error)));
    }
    return Context(context);
}

std::string advice_on(int error) {
    switch (error) {
    case LIBUSB_ERROR_ACCESS:
        return "no permission; plug the board in again, at the computer where you are logged in; "
               "if springdrive was not installed as a package, first copy "
               "setup/70-springdrive-usb.rules to /etc/udev/rules.d";
    case LIBUSB_ERROR_BUSY:
        return "another program uses it; end that program";
    case LIBUSB_ERROR_NO_DEVICE:
    case LIBUSB_ERROR_NOT_FOUND:
    case LIBUSB_ERROR_IO:
        return "it does not answer; plug it in again";
    default:
        return std::string(libusb_strerror(error)) + "; plug it in again";
    }
}

std::string_view name_of_speed(int speed) {
    switch (speed) {
    case LIBUSB_SPEED_LOW:
        return "low speed (1.5 Mbit/s)";
    case LIBUSB_SPEED_FULL:
        return "full speed (12 Mbit/s)";
    case LIBUSB_SPEED_HIGH:
        return "high speed (480 Mbit/s)";
    case LIBUSB_SPEED_SUPER:
    case LIBUSB_SPEED_SUPER_PLUS:
        return "super speed (5 Gbit/s or more)";
    default:
        return "an unknown speed";
    }
}

OpenedBoard open_board_named(libusb_context *context, const std::string &serial) {
    const DeviceList devices(context);
    const ConnectedBoards connected = connected_in(devices);
    std::vector<OpenedBoard> boards = open_all(connected);
    if (boards.empty()) {
        throw InputError("no USB board is connected; plug one in and switch its power on, or use "
                         "--device sim" +
                         (connected.others.empty()
                              ? ""
                              : "; " + connected.others +
                                    " has a board's numbers, but not its interface: another "
                                    "product, or a board without its firmware"));
    }
    const auto found = serial.empty() && boards.size() == 1
                           ? boards.begin()
                           : std::ranges::find(boards, serial, &OpenedBoard::serial);
    if (serial.empty() && boards.size() > 1) {
        throw InputError("several USB boards are connected: " + list_of(boards) +
                         "; name one by --device usb:SERIAL");
    }
    if (found == boards.end()) {
        throw InputError(fmt::format("no USB board with the serial number '{}' is connected, but "
                                     "{}",
                                     serial, list_of(boards)));
    }
    if (!found->problem.empty()) {
        throw InputError("the USB board at " + found->place + ": " + found->problem);
    }
    return std::move(*found);
}

std::vector<FoundBoard> boards_present() {
    const Context context = make_context();
    const DeviceList devices(context.get());
    std::vector<FoundBoard> found;
    for (OpenedBoard &board : open_all(connected_in(devices))) {
        found.push_back({std::move(board.serial), std::move(board.problem)});
    }
    return found;
}

std::vector<SurveyedBoard> survey_boards() {
    const Context context = make_context();
    const DeviceList devices(context.get());
    std::vector<SurveyedBoard> boards;
    for (const Connected &connected : connected_in(devices).boards) {
        SurveyedBoard &board = boards.emplace_back();
        if (const int error = survey(connected, board); error != 0) {
            board.obstacle = obstacle_of(error);
            board.problem = advice_on(error);
        }
    }
    return boards;
}

std::string sysfs_name_of(int bus, std::span<const std::uint8_t> ports) {
    if (ports.empty()) {
        return fmt::format("usb{}", bus); // the computer's own hub
    }
    return fmt::format("{}-{}", bus, fmt::join(ports, "."));
}

void take_identity(std::span<const std::uint8_t> answer, SurveyedBoard &board) {
    Identity identity;
    const FrameStatus status = decode(answer.data(), answer.size(), identity);
    if (status != FrameStatus::ok) {
        board.obstacle = BoardObstacle::no_interface;
        board.problem = fmt::format("cannot be asked for its identity: {}; is it a board for "
                                    "springdrive?",
                                    answer.empty() ? "it refuses" : description_of(status));
        return;
    }
    board.serial = text_of(identity.serial);
    board.firmware = fmt::format("{} {}.{}.{}", text_of(identity.name), identity.firmware[0],
                                 identity.firmware[1], identity.firmware[2]);
    if (kProtocolVersion < identity.oldest_version || kProtocolVersion > identity.newest_version) {
        board.obstacle = BoardObstacle::wrong_version;
        board.problem =
            fmt::format("has versions {} to {} of the protocol, this program has "
                        "version {}; install the firmware or the program that fits "
                        "the other",
                        identity.oldest_version, identity.newest_version, kProtocolVersion);
    }
}

} // namespace springdrive::usb
