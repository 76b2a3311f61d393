// A camera's texture, unlit. Grey and depth textures have one channel, which Unity's own unlit shader shows as red.
Shader "ML2 Sensors/Camera Preview"
{
    Properties
    {
        _MainTex ("Texture", 2D) = "black" {}
        _Grey ("One channel", Float) = 0
        _White ("Value shown white", Float) = 1
    }
    SubShader
    {
        Tags { "RenderType" = "Opaque" }
        Pass
        {
            CGPROGRAM
            #pragma vertex Vertex
            #pragma fragment Fragment
            #include "UnityCG.cginc"

            sampler2D _MainTex;
            float _Grey;
            float _White;

            struct Input
            {
                float4 position : POSITION;
                float2 uv : TEXCOORD0;
                UNITY_VERTEX_INPUT_INSTANCE_ID
            };

            struct Interpolated
            {
                float4 position : SV_POSITION;
                float2 uv : TEXCOORD0;
                UNITY_VERTEX_OUTPUT_STEREO
            };

            Interpolated Vertex(Input input)
            {
                Interpolated output;
                UNITY_SETUP_INSTANCE_ID(input);
                UNITY_INITIALIZE_OUTPUT(Interpolated, output);
                UNITY_INITIALIZE_VERTEX_OUTPUT_STEREO(output);
                output.position = UnityObjectToClipPos(input.position);
                output.uv = input.uv;
                return output;
            }

            fixed4 Fragment(Interpolated input) : SV_Target
            {
                float4 value = tex2D(_MainTex, input.uv) / _White;
                return _Grey > 0.5 ? fixed4(value.rrr, 1) : fixed4(value.rgb, 1);
            }
            ENDCG
        }
    }
}
