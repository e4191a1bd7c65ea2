//! Figures published in document 003: tables F.1 to F.12 and 4.1.

use super::method::FloorDivision;

/// Errors in the norms L1, L2 and of the largest difference.
pub(super) type NormErrors = [f64; 3];

/// A scene's tables in the order of [`super::method::methods`].
struct PublishedTables {
    grid: [NormErrors; 9],
    quadtree: [NormErrors; 7],
    /// Of the quadtree.
    elements: u64,
    /// Seconds: constant, bilinear, spline, Shepard, multiquadrics, natural neighbours.
    grid_times: [f64; 6],
    /// Constant, Shepard, multiquadrics, natural neighbours.
    quadtree_times: [f64; 4],
    reference_time: f64,
}

static PRINTED: [PublishedTables; 6] = [
    PublishedTables {
        grid: [
            [0.0183, 0.0327, 0.223],
            [0.004_64, 0.008_49, 0.0394],
            [0.005_06, 0.009_79, 0.0539],
            [0.0118, 0.0186, 0.0974],
            [0.006_01, 0.0105, 0.056],
            [0.008_17, 0.0163, 0.0749],
            [0.0118, 0.0187, 0.0973],
            [0.006_61, 0.0108, 0.0561],
            [0.004_77, 0.008_43, 0.0391],
        ],
        quadtree: [
            [0.0227, 0.0332, 0.158],
            [0.0282, 0.038, 0.14],
            [0.0084, 0.0131, 0.0708],
            [0.024, 0.0304, 0.0749],
            [0.0285, 0.0381, 0.14],
            [0.0101, 0.0146, 0.0708],
            [0.019, 0.0247, 0.0749],
        ],
        elements: 100,
        grid_times: [0.2, 0.4, 6.5, 57.7, 61.9, 18.4],
        quadtree_times: [0.2, 27.0, 27.2, 11.5],
        reference_time: 727.2,
    },
    PublishedTables {
        grid: [
            [0.0167, 0.0308, 0.189],
            [0.006_28, 0.0102, 0.0429],
            [0.001_58, 0.003_19, 0.0209],
            [0.0114, 0.0189, 0.105],
            [0.002_12, 0.003_57, 0.0241],
            [0.01, 0.0174, 0.0749],
            [0.0114, 0.0189, 0.105],
            [0.002_67, 0.004_34, 0.0218],
            [0.006_63, 0.0104, 0.0449],
        ],
        quadtree: [
            [0.0205, 0.0312, 0.272],
            [0.0237, 0.0329, 0.137],
            [0.005_53, 0.007_67, 0.0426],
            [0.0187, 0.0255, 0.0719],
            [0.0241, 0.0331, 0.136],
            [0.007_48, 0.0101, 0.0426],
            [0.0137, 0.0185, 0.062],
        ],
        elements: 154,
        grid_times: [0.2, 0.4, 6.5, 57.6, 61.9, 18.5],
        quadtree_times: [0.2, 37.6, 38.6, 12.9],
        reference_time: 712.9,
    },
    PublishedTables {
        grid: [
            [0.005_12, 0.0146, 0.3],
            [0.007_38, 0.029, 0.321],
            [0.0096, 0.0287, 0.32],
            [0.0071, 0.0215, 0.312],
            [0.0105, 0.0291, 0.319],
            [0.0125, 0.0366, 0.323],
            [0.007_26, 0.0217, 0.312],
            [0.0108, 0.0293, 0.319],
            [0.008_03, 0.0294, 0.323],
        ],
        quadtree: [
            [0.007, 0.0119, 0.152],
            [0.0417, 0.0617, 0.303],
            [0.0257, 0.0463, 0.316],
            [0.0248, 0.0479, 0.325],
            [0.0359, 0.058, 0.304],
            [0.0223, 0.0437, 0.317],
            [0.0141, 0.0395, 0.325],
        ],
        elements: 232,
        grid_times: [0.2, 0.4, 6.5, 57.6, 61.7, 18.5],
        quadtree_times: [0.3, 53.0, 56.1, 18.3],
        reference_time: 659.0,
    },
    PublishedTables {
        grid: [
            [0.0153, 0.0484, 0.333],
            [0.0121, 0.0385, 0.314],
            [0.0108, 0.0347, 0.311],
            [0.0143, 0.0438, 0.325],
            [0.0109, 0.0344, 0.311],
            [0.0169, 0.0442, 0.315],
            [0.0143, 0.0438, 0.325],
            [0.0113, 0.0345, 0.311],
            [0.0125, 0.0386, 0.315],
        ],
        quadtree: [
            [0.007_93, 0.0155, 0.329],
            [0.0407, 0.0558, 0.273],
            [0.0244, 0.0413, 0.265],
            [0.0158, 0.0296, 0.291],
            [0.0327, 0.0482, 0.273],
            [0.0225, 0.0399, 0.265],
            [0.006_26, 0.0182, 0.291],
        ],
        elements: 301,
        grid_times: [0.2, 0.4, 6.5, 57.7, 61.7, 19.4],
        quadtree_times: [0.2, 66.6, 72.3, 18.7],
        reference_time: 660.2,
    },
    PublishedTables {
        grid: [
            [0.0124, 0.0463, 0.332],
            [0.0105, 0.037, 0.319],
            [0.008_82, 0.0343, 0.32],
            [0.0121, 0.0409, 0.332],
            [0.009_04, 0.0344, 0.321],
            [0.0152, 0.0413, 0.314],
            [0.0122, 0.041, 0.332],
            [0.009_49, 0.0345, 0.321],
            [0.011, 0.0369, 0.314],
        ],
        quadtree: [
            [0.007_46, 0.0139, 0.277],
            [0.0812, 0.107, 0.291],
            [0.006_72, 0.012, 0.176],
            [0.0103, 0.0183, 0.251],
            [0.0669, 0.0939, 0.291],
            [0.005_54, 0.011, 0.176],
            [0.005_11, 0.0102, 0.251],
        ],
        elements: 631,
        grid_times: [0.2, 0.4, 6.4, 57.7, 61.9, 18.9],
        quadtree_times: [0.2, 133.4, 170.6, 36.7],
        reference_time: 651.0,
    },
    PublishedTables {
        grid: [
            [0.0119, 0.0417, 0.441],
            [0.0102, 0.0345, 0.314],
            [0.008_34, 0.0309, 0.311],
            [0.0113, 0.035, 0.389],
            [0.008_55, 0.0309, 0.308],
            [0.0152, 0.0399, 0.305],
            [0.0114, 0.0351, 0.389],
            [0.009_06, 0.031, 0.307],
            [0.0108, 0.0346, 0.305],
        ],
        quadtree: [
            [0.009_68, 0.0233, 0.422],
            [0.0732, 0.1, 0.314],
            [0.008_72, 0.0199, 0.302],
            [0.015, 0.0292, 0.273],
            [0.0589, 0.0851, 0.314],
            [0.008_09, 0.0191, 0.302],
            [0.009_01, 0.0215, 0.273],
        ],
        elements: 511,
        grid_times: [0.2, 0.4, 6.4, 57.8, 61.7, 18.6],
        quadtree_times: [0.2, 109.4, 129.6, 32.5],
        reference_time: 650.5,
    },
];

/// Errors of a scene (0 to 5), by the methods of a division.
pub(super) fn errors(scene: usize, division: FloorDivision) -> &'static [NormErrors] {
    match (PRINTED.get(scene), division) {
        (Some(printed), FloorDivision::Grid) => &printed.grid,
        (Some(printed), FloorDivision::Quadtree) => &printed.quadtree,
        (None, _) => &[],
    }
}

/// Elements of a scene's floor.
pub(super) fn elements(scene: usize, division: FloorDivision) -> Option<u64> {
    let printed = PRINTED.get(scene)?;
    Some(if division == FloorDivision::Grid { 256 } else { printed.elements })
}

/// Seconds on the document's machine by the interpolations of a division, in the order of the table.
pub(super) fn times(scene: usize, division: FloorDivision) -> &'static [f64] {
    match (PRINTED.get(scene), division) {
        (Some(printed), FloorDivision::Grid) => &printed.grid_times,
        (Some(printed), FloorDivision::Quadtree) => &printed.quadtree_times,
        (None, _) => &[],
    }
}

/// Seconds that the reference took on the document's machine.
pub(super) fn reference_time(scene: usize) -> Option<f64> {
    PRINTED.get(scene).map(|printed| printed.reference_time)
}
