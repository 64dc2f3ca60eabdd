// Covers device/usb/driver/libusb_boards.cpp with devices that a libusb of this test's has: it
// replaces that of the system in this program.
#include "device/usb/driver/libusb_boards.h"

#include "base/input_error.h"
#include "device/usb/driver/board_survey.h"
#include "device/usb/protocol.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

// Opaque types of libusb, as they are here.

struct libusb_device { // NOLINT(readability-identifier-naming)
    libusb_device_descriptor description{};
    std::vector<libusb_interface_descriptor> interfaces;
    std::string serial;
    int opening_error = 0;
    int openings = 0;
};

struct libusb_device_handle { // NOLINT(readability-identifier-naming)
    libusb_device *device = nullptr;
};

namespace {

std::vector<libusb_device> plugged_in; // NOLINT

/// What `libusb_get_active_config_descriptor` returns; each setting is the only one.
struct Configuration {
    libusb_config_descriptor description{};
    std::vector<libusb_interface> interfaces;
};

constexpr std::uint8_t kInterrupt = LIBUSB_TRANSFER_TYPE_INTERRUPT;
constexpr std::array<libusb_endpoint_descriptor, 2> kEndpoints{
    {{7, LIBUSB_DT_ENDPOINT, 0x01, kInterrupt, 64, 1, 0, 0, nullptr, 0},
     {7, LIBUSB_DT_ENDPOINT, 0x82, kInterrupt, 64, 1, 0, 0, nullptr, 0}}};

} // namespace

extern "C" {

int libusb_init(libusb_context **context) {
    *context = nullptr;
    return 0;
}
void libusb_exit(libusb_context * /*context*/) {}
ssize_t libusb_get_device_list(libusb_context * /*context*/, libusb_device ***list) {
    *list = new libusb_device *[plugged_in.size() + 1](); // NOLINT
    std::ranges::transform(plugged_in, *list, [](libusb_device &device) { return &device; });
    return static_cast<ssize_t>(plugged_in.size());
}
void libusb_free_device_list(libusb_device **list, int /*unreference*/) { delete[] list; } // NOLINT
int libusb_get_device_descriptor(libusb_device *device, libusb_device_descriptor *description) {
    *description = device->description;
    return 0;
}
int libusb_get_active_config_descriptor(libusb_device *device, libusb_config_descriptor **result) {
    if (device->interfaces.empty()) {
        return LIBUSB_ERROR_NOT_FOUND; // not configured
    }
    auto *const configuration = new Configuration; // NOLINT
    for (const libusb_interface_descriptor &setting : device->interfaces) {
        configuration->interfaces.push_back({&setting, 1});
    }
    configuration->description.bNumInterfaces =
        static_cast<std::uint8_t>(configuration->interfaces.size());
    configuration->description.interface = configuration->interfaces.data();
    *result = &configuration->description;
    return 0;
}
void libusb_free_config_descriptor(libusb_config_descriptor *description) {
    delete reinterpret_cast<Configuration *>(description); // NOLINT: its first member
}
std::uint8_t libusb_get_bus_number(libusb_device * /*device*/) { return 1; }
std::uint8_t libusb_get_device_address(libusb_device *device) {
    return static_cast<std::uint8_t>(device - plugged_in.data() + 1);
}
int libusb_get_port_numbers(libusb_device *device, std::uint8_t *ports, int /*size*/) {
    ports[0] = libusb_get_device_address(device); // NOLINT
    return 1;
}
int libusb_get_device_speed(libusb_device * /*device*/) { return LIBUSB_SPEED_HIGH; }
int libusb_open(libusb_device *device, libusb_device_handle **handle) {
    ++device->openings;
    if (device->opening_error == 0) {
        *handle = new libusb_device_handle{device}; // NOLINT
    }
    return device->opening_error;
}
void libusb_close(libusb_device_handle *handle) { delete handle; } // NOLINT
int libusb_get_string_descriptor_ascii(libusb_device_handle *handle, std::uint8_t /*index*/,
                                       unsigned char *text, int /*size*/) {
    std::ranges::copy(handle->device->serial, text);
    return static_cast<int>(handle->device->serial.size());
}
int libusb_claim_interface(libusb_device_handle * /*handle*/, int /*number*/) { return 0; }
int libusb_release_interface(libusb_device_handle * /*handle*/, int /*number*/) { return 0; }
int libusb_control_transfer(libusb_device_handle *handle, std::uint8_t /*type*/,
                            std::uint8_t /*request*/, std::uint16_t /*value*/,
                            std::uint16_t /*index*/, unsigned char *data, std::uint16_t /*size*/,
                            unsigned /*timeout_ms*/) {
    springdrive::usb::Identity identity;
    std::ranges::copy(handle->device->serial, identity.serial.begin());
    const auto answer = springdrive::usb::encode(identity);
    std::ranges::copy(answer, data);
    return static_cast<int>(answer.size());
}
}

namespace springdrive::usb {
namespace {

libusb_interface_descriptor interface_of(std::uint8_t of_class, std::uint8_t subclass,
                                         std::uint8_t number = 0) {
    libusb_interface_descriptor description{};
    description.bInterfaceNumber = number;
    description.bInterfaceClass = of_class;
    description.bInterfaceSubClass = subclass;
    description.bInterfaceProtocol = kInterfaceProtocol;
    description.bNumEndpoints = kEndpoints.size();
    description.endpoint = kEndpoints.data();
    return description;
}

/// A device with a board's numbers.
libusb_device device_with(std::vector<libusb_interface_descriptor> interfaces,
                          const std::string &serial) {
    libusb_device device;
    device.description.idVendor = kVendorId;
    device.description.idProduct = kProductId;
    device.interfaces = std::move(interfaces);
    device.serial = serial;
    return device;
}

libusb_device board(const std::string &serial) {
    return device_with({interface_of(kInterfaceClass, kInterfaceSubclass)}, serial);
}

/// Whatever else somebody tests with these numbers.
std::vector<libusb_device> others() {
    std::vector<libusb_device> all{
        device_with({interface_of(kInterfaceClass, 0)}, "other"),
        device_with({interface_of(LIBUSB_CLASS_HID, kInterfaceSubclass)}, "keyboard"),
        device_with({}, "not configured"),
    };
    all.front().opening_error = LIBUSB_ERROR_ACCESS;
    return all;
}

TEST(LibusbBoards, OtherProductsWithTheSameNumbersAreNoBoards) {
    plugged_in = others();
    plugged_in.push_back(board("A7"));
    const std::vector<FoundBoard> found = boards_present();
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].serial, "A7");
    EXPECT_EQ(found[0].problem, "");
    EXPECT_EQ(open_board_named(nullptr, "").serial, "A7"); // not one of several
    const std::vector<SurveyedBoard> surveyed = survey_boards();
    ASSERT_EQ(surveyed.size(), 1U);
    EXPECT_EQ(surveyed[0].serial, "A7");
    EXPECT_EQ(surveyed[0].sysfs_name, "1-4");
    EXPECT_TRUE(
        std::ranges::all_of(plugged_in.begin(), plugged_in.end() - 1,
                            [](const libusb_device &other) { return other.openings == 0; }));
}

TEST(LibusbBoards, AloneTheyAreSaidToHaveTheNumbersOnly) {
    plugged_in = {others().front()};
    EXPECT_TRUE(boards_present().empty());
    EXPECT_TRUE(survey_boards().empty());
    const std::string error =
        error_text_of([] { static_cast<void>(open_board_named(nullptr, "")); });
    EXPECT_EQ(error.find("no USB board is connected; plug one in"), 0U) << error;
    EXPECT_NE(error.find("bus 1 device 1 has a board's numbers, but not its interface"),
              std::string::npos)
        << error;
}

TEST(LibusbBoards, OneOfSeveralIsNamed) {
    plugged_in = {board("A7"), others().front(), board("B8")};
    EXPECT_EQ(error_text_of([] { static_cast<void>(open_board_named(nullptr, "")); }),
              "several USB boards are connected: A7, B8; name one by --device usb:SERIAL");
    EXPECT_EQ(open_board_named(nullptr, "B8").serial, "B8");
}

TEST(LibusbBoards, TheInterfaceMayBeOneOfSeveral) {
    plugged_in = {device_with(
        {interface_of(LIBUSB_CLASS_COMM, 2), interface_of(kInterfaceClass, kInterfaceSubclass, 1)},
        "A7")};
    EXPECT_EQ(open_board_named(nullptr, "").endpoints.interface_number, 1);
    plugged_in.front().description.idProduct = kProductId + 1;
    EXPECT_TRUE(boards_present().empty()); // nor is the interface alone
}

} // namespace
} // namespace springdrive::usb
