namespace Ml2Sensors.Geometry
{
    /// <summary>
    /// Camera intrinsics from the device, for an image of Width x Height pixels. The origin is the centre of the top left
    /// pixel, with x to the right and y down.
    /// </summary>
    public readonly struct CameraIntrinsics
    {
        /// <summary>Pixels per row.</summary>
        public readonly int Width;

        /// <summary>Rows.</summary>
        public readonly int Height;

        /// <summary>Focal length in pixels along x.</summary>
        public readonly double Fx;

        /// <summary>Focal length in pixels along y.</summary>
        public readonly double Fy;

        /// <summary>Principal point in pixels from the left.</summary>
        public readonly double Cx;

        /// <summary>Principal point in pixels from the top.</summary>
        public readonly double Cy;

        /// <summary>The distortion of the lens.</summary>
        public readonly LensDistortion Distortion;

        /// <summary>Creates intrinsics; all lengths are in pixels.</summary>
        public CameraIntrinsics(int width, int height, double fx, double fy, double cx, double cy, in LensDistortion distortion)
        {
            Width = width;
            Height = height;
            Fx = fx;
            Fy = fy;
            Cx = cx;
            Cy = cy;
            Distortion = distortion;
        }
    }

    /// <summary>The distortion model, ml2s_lens in native/sdk/ml2s.h.</summary>
    public enum LensModel
    {
        /// <summary>RGB and depth: K1, K2, P1, P2, K3 as in OpenCV; K4 is 0.</summary>
        PlumbBob = 0,

        /// <summary>World cameras: equidistant with K1 to K4, then tangential with P1 and P2.</summary>
        FisheyeTangential = 1,
    }

    /// <summary>The coefficients of a lens model.</summary>
    public readonly struct LensDistortion
    {
        /// <summary>The model that the coefficients belong to.</summary>
        public readonly LensModel Model;

#pragma warning disable 1591 // The names are those of OpenCV.
        public readonly double K1, K2, K3, K4;
        public readonly double P1, P2;
#pragma warning restore 1591

        /// <summary>Takes the coefficients in the order of ml2s_frame.distortion, which depends on the model.</summary>
        internal LensDistortion(LensModel model, double d0, double d1, double d2, double d3, double d4, double d5)
        {
            bool isFisheye = model == LensModel.FisheyeTangential;
            Model = model;
            K1 = d0;
            K2 = d1;
            K3 = isFisheye ? d2 : d4;
            K4 = isFisheye ? d3 : 0;
            P1 = isFisheye ? d4 : d2;
            P2 = isFisheye ? d5 : d3;
        }
    }
}
