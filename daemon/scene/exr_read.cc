#include "scene/exr_read.h"

#include <Iex.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace
{

class memory_stream : public Imf::IStream
{
  public:
    memory_stream(const uint8_t *bytes, size_t size)
        : Imf::IStream("picture"), bytes_(bytes), size_(size)
    {
    }

    bool read(char to[], int n) override
    {
        if (n < 0 || (size_t)n > size_ - at_)
            throw Iex::InputExc("the file ends early");
        std::memcpy(to, bytes_ + at_, (size_t)n);
        at_ += (size_t)n;
        return at_ < size_;
    }

    uint64_t tellg() override
    {
        return at_;
    }

    void seekg(uint64_t to) override
    {
        if (to > size_)
            throw Iex::InputExc("the file points beyond its end");
        at_ = (size_t)to;
    }

  private:
    const uint8_t *bytes_;
    size_t size_, at_ = 0;
};

struct channel_names {
    std::string name[3];
};

// "layer." of a channel "layer.R", "" of "R".
std::string layer_of(const std::string &channel)
{
    const size_t dot = channel.rfind('.');
    return dot == std::string::npos ? "" : channel.substr(0, dot + 1);
}

bool find_in_layer(const Imf::ChannelList &all, const std::string &layer, channel_names &out)
{
    const std::string r = layer + "R", g = layer + "G", b = layer + "B", y = layer + "Y";
    if (all.findChannel(r) && all.findChannel(g) && all.findChannel(b)) {
        out = {{r, g, b}};
        return true;
    }
    if (!all.findChannel(y))
        return false;
    out = {{y, y, y}};
    return true;
}

bool find_channels(const Imf::Header &header, channel_names &out)
{
    const Imf::ChannelList &all = header.channels();
    if (header.hasType() && header.type() != Imf::SCANLINEIMAGE && header.type() != Imf::TILEDIMAGE)
        return false;
    if (find_in_layer(all, "", out))
        return true;
    for (auto c = all.begin(); c != all.end(); ++c)
        if (find_in_layer(all, layer_of(c.name()), out))
            return true;
    return false;
}

int64_t extent(int low, int high)
{
    return (int64_t)high - low + 1;
}

void check_size(const Imath::Box2i &box, uint32_t side, const char *what)
{
    const int64_t w = extent(box.min.x, box.max.x), h = extent(box.min.y, box.max.y);
    if (w >= 1 && h >= 1 && w <= side && h <= side)
        return;
    char text[120];
    std::snprintf(text, sizeof text, "its %s is %lldx%lld; at most %u on a side", what,
                  (long long)w, (long long)h, side);
    throw Iex::InputExc(text);
}

enum glint_exr_result say(struct glint_exr_fault *fault, const char *text)
{
    std::snprintf(fault->text, sizeof fault->text, "%s", text);
    for (char *c = fault->text; *c; c++)
        if ((unsigned char)*c < ' ' || (unsigned char)*c > '~')
            *c = ' ';
    return GLINT_EXR_FAULT;
}

} // namespace

struct glint_exr {
    memory_stream stream;
    Imf::MultiPartInputFile file;
    std::unique_ptr<Imf::InputPart> part;
    channel_names channel;
    Imath::Box2i data, display;
    std::vector<float> row; // of the data window, [width][3]

    glint_exr(const uint8_t *bytes, size_t size, uint32_t side)
        : stream(bytes, size), file(stream, 0, false)
    {
        int chosen = 0;
        while (chosen < file.parts() && !find_channels(file.header(chosen), channel))
            chosen++;
        if (chosen == file.parts())
            throw Iex::InputExc("it has no flat part with channels R, G and B, or Y");
        data = file.header(chosen).dataWindow();
        display = file.header(chosen).displayWindow();
        check_size(data, side, "data window");
        check_size(display, side, "display window");
        part.reset(new Imf::InputPart(file, chosen));
        row.resize(3 * (size_t)extent(data.min.x, data.max.x));
        attach();
    }

  private:
    // Every line of the file goes to the one row.
    void attach()
    {
        Imf::FrameBuffer buffer;
        const ptrdiff_t step = 3 * sizeof(float);
        for (int k = 0; k < 3; k++) {
            if (k && channel.name[k] == channel.name[0])
                continue; // Y is read once
            char *base = reinterpret_cast<char *>(row.data() + k) - data.min.x * step;
            buffer.insert(channel.name[k], Imf::Slice(Imf::FLOAT, base, (size_t)step, 0));
        }
        part->setFrameBuffer(buffer);
    }
};

enum glint_exr_result glint_exr_open(struct glint_exr **out, const uint8_t *bytes, size_t size,
                                     uint32_t side, struct glint_exr_fault *fault)
{
    *out = nullptr;
    try {
        Imf::Header::setMaxImageSize((int)side, (int)side);
        Imf::Header::setMaxTileSize(4096, 4096);
        *out = new glint_exr(bytes, size, side);
        return GLINT_EXR_OK;
    } catch (const std::bad_alloc &) {
        return GLINT_EXR_NOMEM;
    } catch (const std::exception &e) {
        return say(fault, e.what());
    } catch (...) {
        return say(fault, "it is damaged");
    }
}

uint32_t glint_exr_width(const struct glint_exr *exr)
{
    return (uint32_t)extent(exr->display.min.x, exr->display.max.x);
}

uint32_t glint_exr_height(const struct glint_exr *exr)
{
    return (uint32_t)extent(exr->display.min.y, exr->display.max.y);
}

enum glint_exr_result glint_exr_row(struct glint_exr *exr, uint32_t y, float *rgb,
                                    struct glint_exr_fault *fault)
{
    const Imath::Box2i &data = exr->data, &display = exr->display;
    const int64_t line = (int64_t)display.min.y + y;
    const int64_t low = std::max(data.min.x, display.min.x);
    const int64_t high = std::min(data.max.x, display.max.x);
    std::memset(rgb, 0, 3 * sizeof *rgb * glint_exr_width(exr));
    if (line < data.min.y || line > data.max.y || low > high)
        return GLINT_EXR_OK;
    try {
        exr->part->readPixels((int)line);
    } catch (const std::bad_alloc &) {
        return GLINT_EXR_NOMEM;
    } catch (const std::exception &e) {
        return say(fault, e.what());
    } catch (...) {
        return say(fault, "it is damaged");
    }
    const bool grey = exr->channel.name[0] == exr->channel.name[1];
    for (int64_t x = low; x <= high; x++)
        for (int k = 0; k < 3; k++)
            rgb[3 * (x - display.min.x) + k] = exr->row[3 * (x - data.min.x) + (grey ? 0 : k)];
    return GLINT_EXR_OK;
}

void glint_exr_close(struct glint_exr **exr)
{
    delete *exr;
    *exr = nullptr;
}
