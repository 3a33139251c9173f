#include "scenes.h"

void glint_scene_light(struct glint_document *d, const double from[3], double radiance, double size)
{
    cJSON *light = cJSON_AddObjectToObject(d->lights, "light");
    cJSON_AddStringToObject(light, "type", "area");
    cJSON_AddItemToObject(light, "intensity", glint_document_number(radiance));
    cJSON_AddItemToObject(light, "size", glint_document_numbers((double[]){size, size}, 2));
    cJSON_AddItemToObject(light, "transform", glint_document_aim(from, (double[]){0, 0, 0}));
}

void glint_scene_sky(struct glint_document *d, double radiance)
{
    cJSON *sky = cJSON_AddObjectToObject(d->root, "environment");
    cJSON_AddItemToObject(sky, "radiance",
                          glint_document_numbers((double[]){radiance, radiance, radiance}, 3));
}

void glint_scene_camera(struct glint_document *d, const double from[3], const double to[3],
                        double yfov)
{
    cJSON *camera = cJSON_AddObjectToObject(d->cameras, "camera");
    cJSON_AddItemToObject(camera, "yfov", glint_document_number(yfov));
    cJSON_AddItemToObject(camera, "transform", glint_document_aim(from, to));
}
