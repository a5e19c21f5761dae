// How much a smooth interface reflects.

// Schlick's weight of the reflectance at grazing incidence against that at normal incidence
// (Schlick 1994, eq. 24). Cosines a few ULP outside [0, 1] are harmless.
fn fresnel_schlick_weight(cosine: f32) -> f32 {
    let x = clamp(1.0 - cosine, 0.0, 1.0);
    let x2 = x * x;
    return x2 * x2 * x;
}

// Unpolarised reflectance of a dielectric; `eta` is the index on the far side over that on the near
// side. 1 under total internal reflection: g, which is eta · cosθt, is then 0 and both
// polarisations reflect fully. (Born & Wolf, section 1.5.2, eqs. 21a; written in g as Walter et al.
// 2007, eq. 22, but without its cancellation at eta = 1.)
fn fresnel_dielectric(cosine: f32, eta: f32) -> f32 {
    let g = fresnel_g(cosine, eta);
    let e = eta * eta * cosine;
    let s = (cosine - g) / max(cosine + g, 1e-20);
    let p = (e - g) / max(e + g, 1e-20);
    return 0.5 * (s * s + p * p);
}

// eta · cosθt by Snell's law; 0 under total internal reflection.
fn fresnel_g(cosine: f32, eta: f32) -> f32 {
    return sqrt(max(eta * eta - 1.0 + cosine * cosine, 0.0));
}

// Reflectance of that interface at normal incidence.
fn fresnel_normal_incidence(eta: f32) -> f32 {
    let r = (eta - 1.0) / (eta + 1.0);
    return r * r;
}
