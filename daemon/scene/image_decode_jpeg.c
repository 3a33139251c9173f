// image_decode_jpeg.c - JPEG by libjpeg-turbo to RGBA8.
#include "scene/image_decode.h"

#include <setjmp.h>
#include <stdio.h>

#include <jpeglib.h>

#include <jerror.h>

struct failure {
    struct jpeg_error_mgr base; // first: libjpeg knows only this part
    jmp_buf jump;
    char why[JMSG_LENGTH_MAX];
};

static void failed(j_common_ptr info)
{
    struct failure *f = (struct failure *)info->err;
    info->err->format_message(info, f->why);
    longjmp(f->jump, 1);
}

// Missing data is only a warning to libjpeg, which fills it with grey.
static void told(j_common_ptr info, int level)
{
    const int code = info->err->msg_code;
    if (level < 0 && (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER))
        failed(info);
}

static glint_status read_rows(struct jpeg_decompress_struct *jpeg, struct glint_pixels *out,
                              struct glint_arena *arena, const char *pointer,
                              struct glint_error *err)
{
    jpeg_read_header(jpeg, TRUE);
    if (jpeg->num_components == 4)
        return glint_fail(err, GLINT_E_RANGE, pointer, "the JPEG is CMYK, which is not read");
    const glint_status st = glint_pixels_alloc(out, arena, jpeg->image_width, jpeg->image_height,
                                               GLINT_IMAGE_RGBA8, pointer, err);
    if (st)
        return st;
    jpeg->out_color_space = JCS_EXT_RGBA;
    jpeg_start_decompress(jpeg);
    while (jpeg->output_scanline < jpeg->output_height) {
        JSAMPROW row = (JSAMPROW)out->pixels + (size_t)jpeg->output_scanline * out->width * 4;
        jpeg_read_scanlines(jpeg, &row, 1);
    }
    jpeg_finish_decompress(jpeg);
    return GLINT_OK;
}

glint_status glint_image_decode_jpeg(struct glint_pixels *out, struct glint_arena *arena,
                                     const uint8_t *bytes, size_t size, const char *pointer,
                                     struct glint_error *err)
{
    struct jpeg_decompress_struct jpeg = {0};
    struct failure failure;
    jpeg.err = jpeg_std_error(&failure.base);
    failure.base.error_exit = failed;
    failure.base.emit_message = told;
    glint_status st;
    if (setjmp(failure.jump)) {
        st = glint_fail(err, GLINT_E_RANGE, pointer, "the JPEG is damaged: %s", failure.why);
    } else {
        jpeg_create_decompress(&jpeg);
        jpeg_mem_src(&jpeg, bytes, size);
        st = read_rows(&jpeg, out, arena, pointer, err);
    }
    jpeg_destroy_decompress(&jpeg);
    return st;
}
