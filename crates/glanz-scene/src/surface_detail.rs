//! Bumps and maps of normals: detail that changes the shading normal.

use glanz_geometry::{Hit, SurfacePoint};
use glanz_math::{DVec2, DVec3, Ray, Transform};
use glanz_shading::Textures;
use glanz_shading::texture::{FloatInput, ImageFilter, ImageWrap, MipMap, TextureFootprint, TexturePoint};

use crate::interaction::Interaction;
use crate::object::SceneObject;
use crate::scene::Scene;

/// Step in the texture coordinates for differences of heights.
///
/// # Source
/// @pbrt4 `BumpMap`: its step without ray differentials.
const STEP: f64 = 0.0005;

/// Detail of the surfaces of a material.
#[derive(Clone, Debug)]
pub(crate) enum SurfaceDetail {
    /// The height above the surface, metres.
    Bump(FloatInput),
    /// Components of the normal as colours.
    NormalMap(MipMap),
}

impl SurfaceDetail {
    /// The shading normal at a point, of unit length, whose undisturbed one has the derivatives `[dn/du, dn/dv]`. `None` where it is not defined, or
    /// more than 90 degrees from that of the surface.
    fn shading_normal(
        &self,
        textures: &Textures,
        point: &SurfacePoint,
        derivatives: [DVec3; 2],
        footprint: Option<TextureFootprint>,
    ) -> Option<DVec3> {
        let normal = match self {
            Self::Bump(height) => bumped_normal(textures, height, point, derivatives, footprint)?,
            Self::NormalMap(picture) => mapped_normal(picture, point)?,
        };
        (normal.dot(point.normal) > 0.0).then_some(normal)
    }
}

/// The normal of the surface displaced by a height along its shading normal, by forward differences.
///
/// # Source
/// @pbrt4 `BumpMap`. Departure: on meshes with normals at the vertices, both tangents are the projections of the derivatives of the
/// position, not perpendicular ones of the length of the first.
fn bumped_normal(
    textures: &Textures,
    height: &FloatInput,
    point: &SurfacePoint,
    [dndu, dndv]: [DVec3; 2],
    footprint: Option<TextureFootprint>,
) -> Option<DVec3> {
    let &SurfacePoint { position, normal, shading_normal: n, uv, dpdu, dpdv, .. } = point;
    let height = |du: f64, dv: f64| {
        let moved = TexturePoint::new(uv + DVec2::new(du, dv), position + du * dpdu + dv * dpdv);
        f64::from(textures.float(height, &moved.with_normal(normal).with_footprint(footprint)))
    };
    let here = height(0.0, 0.0);
    let slopes = [height(STEP, 0.0) - here, height(0.0, STEP) - here].map(|difference| difference / STEP);
    let tangent = |dp: DVec3, slope: f64, dn: DVec3| dp - n * n.dot(dp) + slope * n + here * dn;
    let displaced = tangent(dpdu, slopes[0], dndu).cross(tangent(dpdv, slopes[1], dndv)).try_normalize()?;
    Some(if displaced.dot(n) < 0.0 { -displaced } else { displaced })
}

/// The normal of a picture in the frame of the shading normal and the derivative of the position by u.
///
/// # Source
/// @pbrt4 `NormalMap`, without a filter: light reflected by a mean normal is not the mean of the reflected light. Departure: green leans towards growing v also where the texture coordinates or the surface are mirrored, as in @khr_gltf.
fn mapped_normal(picture: &MipMap, point: &SurfacePoint) -> Option<DVec3> {
    let rgb = picture.lookup(point.uv, [DVec2::ZERO; 2], ImageWrap::Repeat, ImageFilter::Bilinear);
    let [x, y, z] = rgb.map(|c| 2.0 * f64::from(c) - 1.0);
    let n = point.shading_normal;
    let tangent = (point.dpdu - n * n.dot(point.dpdu)).try_normalize()?;
    let across = n.cross(tangent);
    let across = if across.dot(point.dpdv) < 0.0 { -across } else { across };
    (x * tangent + y * across + z * n).try_normalize()
}

impl Scene {
    /// Changes the shading normal at a hit by the detail of its material. `local`: the ray in the frame of the surface. `maps`: the transformations from
    /// the world, outermost first, to the group of the object.
    #[cold]
    pub(crate) fn apply_surface_detail(
        &self,
        at: &mut Interaction,
        object: &SceneObject,
        local: &Ray,
        hit: &Hit,
        maps: &[&Transform],
    ) {
        let Some(detail) = self.surface_details.get(at.material as usize).and_then(Option::as_ref) else {
            return;
        };
        let (point, derivatives) = object.differential_point(local, hit, maps);
        let footprint = at.differential.map(|differential| differential.footprint);
        if let Some(normal) = detail.shading_normal(&self.textures, &point, derivatives, footprint) {
            at.point.shading_normal = normal;
        }
    }
}
