"""What Mitsuba lacks of pbrt's meaning, as plugins."""

import drjit
import mitsuba
import numpy


class Correlated(mitsuba.BSDF):
    """A microfacet BSDF (GGX) whose masking is correlated by height.

    Mitsuba multiplies the masking of both directions, 1 / ((1 + a)(1 + b)); pbrt correlates them by height, 1 / (1 + a + b).
    """

    def __init__(self, properties):
        super().__init__(properties)
        self.widths = properties["alpha_u"], properties["alpha_v"]
        self.nested = properties["nested"]
        self.m_components = [self.nested.flags(i) for i in range(self.nested.component_count())]
        self.m_flags = self.nested.flags()

    def factor(self, wi, wo):
        def slope(w):
            squared = (drjit.square(w.x * self.widths[0]) + drjit.square(w.y * self.widths[1])) / drjit.square(w.z)
            return (drjit.sqrt(1 + squared) - 1) / 2

        a, b = slope(wi), slope(wo)
        return (1 + a) * (1 + b) / (1 + a + b)

    def eval(self, context, si, wo, active):
        return self.nested.eval(context, si, wo, active) * self.factor(si.wi, wo)

    def pdf(self, context, si, wo, active):
        return self.nested.pdf(context, si, wo, active)

    def eval_pdf(self, context, si, wo, active):
        return self.eval(context, si, wo, active), self.pdf(context, si, wo, active)

    def sample(self, context, si, sample1, sample2, active):
        sampled, weight = self.nested.sample(context, si, sample1, sample2, active)
        return sampled, weight * self.factor(si.wi, sampled.wo)

    def to_string(self):
        return f"Correlated[{self.nested}]"


class RoughCoat(Correlated):
    """The facets of Mitsuba's `roughplastic`, with correlated masking, over a diffuse base that loses no light.

    Mitsuba loses what facets block inside; with alpha 0.3 a white base scatters 0.69 of all light. Where it is not lost, what the coat does not reflect
    of a direction, T(w), arrives at the base, and by reciprocity the fraction t / eta^2 of diffuse light from inside leaves, where t is the mean of T. So
    the base scatters T(i) T(o) a / (pi t^2), with the mean albedo a = t R (t / eta^2) / (1 - R (1 - t / eta^2)), or t R without changes of colour between
    coat and base (`saturates` false).
    """

    NODES = 128

    def __init__(self, properties):
        super().__init__(properties)
        self.facets = mitsuba.BSDFContext(mitsuba.TransportMode.Radiance, 0xFFFFFFFF, 0)
        cosines = (numpy.arange(self.NODES) + 0.5) / self.NODES
        transmitted = self.transmitted(cosines)
        mean = float((2 * cosines * transmitted).mean())
        leaving = mean / properties["eta"] ** 2
        reflectance = mitsuba.Color3f(properties["reflectance"])
        albedo = mean * reflectance
        if properties["saturates"]:
            albedo *= leaving / (1 - reflectance * (1 - leaving))
        self.scale = albedo / (mean**2 * drjit.pi)
        self.table = mitsuba.Float(transmitted.astype(numpy.float32))

    def transmitted(self, cosines, side=256):
        """T at these cosines: one minus what facets reflect, over a grid of samples."""
        grid = (numpy.arange(side) + 0.5) / side
        cos, x, y = (mitsuba.Float(c.ravel().astype(numpy.float32)) for c in numpy.meshgrid(cosines, grid, grid, indexing="ij"))
        si = drjit.zeros(mitsuba.SurfaceInteraction3f, drjit.width(cos))
        si.wi = mitsuba.Vector3f(drjit.sqrt(1 - cos * cos), 0, cos)
        sampled, weight = self.nested.sample(self.facets, si, 0.5, mitsuba.Point2f(x, y), True)
        weight = drjit.select(sampled.pdf > 0, weight * self.factor(si.wi, sampled.wo), 0)
        return 1 - numpy.array(weight.x, dtype=float).reshape(len(cosines), -1).mean(axis=1)

    def through(self, cos):
        """T, linear between its values."""
        position = drjit.clip(cos * self.NODES - 0.5, 0, self.NODES - 1.001)
        node = mitsuba.UInt32(position)
        first, second = (drjit.gather(mitsuba.Float, self.table, node + i) for i in (0, 1))
        return drjit.lerp(first, second, position - node)

    def eval(self, context, si, wo, active):
        i, o = mitsuba.Frame3f.cos_theta(si.wi), mitsuba.Frame3f.cos_theta(wo)
        active &= (i > 0) & (o > 0)
        facets = self.nested.eval(self.facets, si, wo, active) * self.factor(si.wi, wo)
        return drjit.select(active, facets + self.scale * self.through(i) * self.through(o) * o, 0)

    def sample(self, context, si, sample1, sample2, active):
        sampled, _ = self.nested.sample(context, si, sample1, sample2, active)
        active &= sampled.pdf > 0
        return sampled, drjit.select(active, self.eval(context, si, sampled.wo, active) / sampled.pdf, 0)


class DiffuseTransmission(mitsuba.BSDF):
    """Diffuse reflection and diffuse transmission, the same on both sides."""

    def __init__(self, properties):
        super().__init__(properties)
        self.reflectance, self.transmittance = (mitsuba.Color3f(properties[name]) for name in ("reflectance", "transmittance"))
        both = mitsuba.BSDFFlags.FrontSide | mitsuba.BSDFFlags.BackSide
        self.m_components = [mitsuba.BSDFFlags.DiffuseReflection | both, mitsuba.BSDFFlags.DiffuseTransmission | both]
        self.m_flags = self.m_components[0] | self.m_components[1]

    def share(self, si, wo):
        """Fraction of light on the side of `wo`."""
        same = mitsuba.Frame3f.cos_theta(si.wi) * mitsuba.Frame3f.cos_theta(wo) > 0
        return drjit.select(same, self.reflectance, self.transmittance)

    def eval(self, context, si, wo, active):
        return drjit.select(active, self.share(si, wo) * drjit.abs(mitsuba.Frame3f.cos_theta(wo)) / drjit.pi, 0)

    def pdf(self, context, si, wo, active):
        return drjit.select(active, drjit.abs(mitsuba.Frame3f.cos_theta(wo)) / (2 * drjit.pi), 0)

    def eval_pdf(self, context, si, wo, active):
        return self.eval(context, si, wo, active), self.pdf(context, si, wo, active)

    def sample(self, context, si, sample1, sample2, active):
        wo = mitsuba.warp.square_to_cosine_hemisphere(sample2)
        reflected = sample1 < 0.5
        wo.z = drjit.select(reflected, wo.z, -wo.z) * drjit.sign(mitsuba.Frame3f.cos_theta(si.wi))
        sampled = drjit.zeros(mitsuba.BSDFSample3f)
        sampled.wo, sampled.eta, sampled.pdf = wo, 1.0, self.pdf(context, si, wo, active)
        sampled.sampled_type = drjit.select(reflected, mitsuba.UInt32(int(mitsuba.BSDFFlags.DiffuseReflection)),
                                            mitsuba.UInt32(int(mitsuba.BSDFFlags.DiffuseTransmission)))
        sampled.sampled_component = drjit.select(reflected, mitsuba.UInt32(0), mitsuba.UInt32(1))
        return sampled, drjit.select(active, 2 * self.share(si, wo), 0)

    def to_string(self):
        return "DiffuseTransmission[]"


class LongitudeLatitude(mitsuba.Sensor):
    """All directions, after pbrt's manual: rows from +y to -y, columns from +x over +z and -x to -z of a left-handed camera."""

    def __init__(self, properties):
        super().__init__(properties)
        self.m_needs_sample_3 = False

    def sample_ray(self, time, wavelength_sample, position_sample, aperture_sample, active=True):
        ray = drjit.zeros(mitsuba.Ray3f)
        phi, theta = 2 * drjit.pi * position_sample.x, drjit.pi * position_sample.y
        # Mitsuba's x points to the left.
        local = mitsuba.Vector3f(-drjit.cos(phi) * drjit.sin(theta), drjit.cos(theta), drjit.sin(phi) * drjit.sin(theta))
        to_world = self.world_transform()
        ray.o, ray.d = to_world @ mitsuba.Point3f(0), to_world @ local
        ray.maxt, ray.time = drjit.inf, time
        return ray, mitsuba.Color3f(1)

    def sample_ray_differential(self, time, wavelength_sample, position_sample, aperture_sample, active=True):
        ray, weight = self.sample_ray(time, wavelength_sample, position_sample, aperture_sample, active)
        return mitsuba.RayDifferential3f(ray), weight

    def to_string(self):
        return "LongitudeLatitude[]"


# Functions of a direction, by the number that `angular` has as `intensity`.
INTENSITIES = []


class Angular(mitsuba.Emitter):
    """A point light whose intensity depends on the direction."""

    def __init__(self, properties):
        super().__init__(properties)
        self.intensity = INTENSITIES[int(properties["intensity"])]
        self.m_flags = int(mitsuba.EmitterFlags.DeltaPosition)

    def sample_direction(self, it, sample, active=True):
        to_world = self.world_transform()
        sampled = drjit.zeros(mitsuba.DirectionSample3f)
        sampled.p = to_world @ mitsuba.Point3f(0)
        sampled.time, sampled.pdf, sampled.delta = it.time, 1.0, True
        sampled.emitter = mitsuba.EmitterPtr(self)
        towards = sampled.p - it.p
        sampled.dist = drjit.norm(towards)
        sampled.d = towards / sampled.dist
        local = drjit.normalize(to_world.inverse() @ mitsuba.Vector3f(-sampled.d))
        value = mitsuba.Color3f(self.intensity(local)) / drjit.square(sampled.dist)
        return sampled, drjit.select(active, value, 0)

    def pdf_direction(self, it, sampled, active=True):
        return mitsuba.Float(0)

    def eval(self, si, active=True):
        return mitsuba.Color3f(0)

    def bbox(self):
        return mitsuba.ScalarBoundingBox3f()

    def to_string(self):
        return "Angular[]"


def register():
    mitsuba.register_emitter("angular", Angular)
    mitsuba.register_bsdf("correlated", Correlated)
    mitsuba.register_bsdf("rough_coat", RoughCoat)
    mitsuba.register_bsdf("diffuse_transmission", DiffuseTransmission)
    mitsuba.register_sensor("longitude_latitude", LongitudeLatitude)
