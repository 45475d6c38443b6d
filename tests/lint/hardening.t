#!/usr/bin/perl
# What the binary, the unit and the compose file do to make a fault of ours harmless.
use strict;
use warnings;
use File::Spec ();
use File::Temp qw(tempdir);
use Test::More;
use YAML::XS ();

my $binary = $ENV{VORONOID} // 'build/release/voronoid';
my $dir = tempdir(CLEANUP => 1);

sub slurp { local (@ARGV, $/) = @_; return scalar <> }

# The binary. Sanitizers take the place of these flags in their own builds.
SKIP: {
    my $symbols = `readelf --wide --dyn-syms $binary 2>&1`;
    skip 'a build of a sanitizer', 7 if $symbols =~ /__asan_init|__tsan_init/;
    my $headers = `readelf --wide --file-header --program-headers --dynamic --notes $binary 2>&1`;
    like $headers, qr/^\s+Type:\s+DYN /m, 'it is loaded anywhere (PIE)';
    like $headers, qr/^\s+GNU_RELRO /m, 'relocations are read-only (RELRO)';
    like $headers, qr/\(FLAGS_1\).*\bNOW\b/, 'all of them, as all are made at the start (BIND_NOW)';
    like $headers, qr/^\s+GNU_STACK .* RW /m, 'the stack holds no code';
    unlike $headers, qr/^\s+LOAD .* RWE /m, 'nothing that can be written can be run';
    like $symbols, qr/__stack_chk_fail/, 'an overrun stack ends the process (canary)';
    skip 'not a build with optimisation', 1 if $binary !~ m{/release/};
    like $symbols, qr/__\w+_chk\b/, 'so does an overrun buffer that the C library fills (FORTIFY)';
}

# The unit.
my $unit = slurp('docker/voronoid.service');
for my $line ('Type=notify', 'DynamicUser=yes', 'StateDirectory=voronoid', 'CapabilityBoundingSet=', 'NoNewPrivileges=yes',
    'KillMode=mixed', 'ExecReload=/bin/kill -HUP $MAINPID') {
    like $unit, qr/^\Q$line\E$/m, "the unit has $line";
}
like $unit, qr/^WatchdogSec=\d+$/m, 'and a watchdog';
like $unit, qr/^SystemCallFilter=seccomp landlock_create_ruleset/m, 'children may shut themselves in';
SKIP: {
    skip 'systemd-analyze: not on this machine', 3 unless -x '/usr/bin/systemd-analyze';
    my $path = File::Spec->rel2abs($binary);
    open my $out, '>', "$dir/voronoid.service" or die $!;
    print $out $unit =~ s{/usr/local/bin/voronoid}{$path}r;
    close $out;
    is `systemd-analyze verify --man=no $dir/voronoid.service 2>&1`, '', 'systemd understands all of it';
    my $said = `systemd-analyze security --no-pager --offline=true $dir/voronoid.service 2>&1`;
    my ($exposure) = $said =~ /exposure level for \S+: ([\d.]+)/;
    ok defined $exposure, 'and says how exposed it is' or diag $said;
    cmp_ok $exposure // 10, '<=', 1.5, 'which is little';
}

# The compose files, and what Kubernetes gets: each daemon is shut in, and would start with the settings that stand there.
sub merged { my %all = %{ $_[0] }; my $below = delete $all{'<<'}; return $below ? { %{ merged($below) }, %all } : \%all }
my ($plain, $scale) = map { YAML::XS::LoadFile($_)->{services} } 'docker/compose.yaml', 'docker/compose.scale.yaml';
for my $service (map { merged($_) } $plain->{voronoid}, @$scale{qw(api-1 api-2 worker)}) {
    ok $service->{read_only}, 'the container\'s root is read-only';
    is "@{ $service->{cap_drop} }", 'ALL', 'it has no capabilities';
    ok !exists $service->{$_}, "nor $_" for qw(cap_add privileged devices network_mode pid);
    is "@{ $service->{security_opt} }", 'no-new-privileges:true', 'and gains none';
    like $service->{user}, qr/^[1-9]\d*:[1-9]\d*$/, 'it is not root';
    cmp_ok $service->{pids_limit}, '<=', 1024, 'its processes are counted';
    like $service->{mem_limit}, qr/^\d+g$/, 'and its memory';
}
is scalar(grep { !/^127\.0\.0\.1:/ } map { @{ $_->{ports} // [] } } values %$plain, values %$scale), 0, 'ports are this machine\'s alone';
like slurp('docker/Dockerfile'), qr/^USER 65532:65532$/m, 'the image itself is not root\'s either';

my %is_setting = map { $_ => 1 } slurp('server/base/config.h') =~ /^    X\(\w+, "([\w-]+)"/mg;
# Starts nothing: whether these settings are valid, with a file in place of each secret.
sub holds {
    my ($name, %set) = @_;
    open my $out, '>', "$dir/secret" or die $!;
    print $out "postgresql://voronoid\@host/voronoid\n";
    local %ENV = (PATH => $ENV{PATH}, slurp('docker/Dockerfile') =~ /^(?:ENV| ) +([A-Z_]+)=(\S+)/mg, map { $_ => $set{$_} =~ m{^/run/} ? "$dir/secret" : $set{$_} } keys %set);
    is join(' ', grep { /^VORONOID_/ && !$is_setting{ lc s/^VORONOID_|_FILE$//gr =~ tr/_/-/r } } keys %set), '', "$name names settings alone";
    is `$binary serve --check-config 2>&1`, "voronoid: the settings are valid\n", "$name would start";
    is join(' ', sort grep { /^AWS_.*_FILE$/ } keys %set), 'AWS_ACCESS_KEY_ID_FILE AWS_SECRET_ACCESS_KEY_FILE', 'and has keys for S3';
}
holds($_, %{ merged(merged($scale->{$_})->{environment}) }) for qw(api-1 api-2 worker);
my %other = slurp('docker/compose.scale.yaml') =~ /^ +# (VORONOID_\w+): (\S+)$/mg;
for my $name (sort keys %other) {
    my %set = (%{ merged(merged($scale->{'api-1'})->{environment}) }, $name => $other{$name});
    delete $set{ $name =~ s/_FILE$//r } if $name =~ /_FILE$/;
    holds("api-1 with $name", %set);
}
my ($kustomization, $without_s3) = map { YAML::XS::LoadFile("docker/$_/kustomization.yaml") } qw(k8s k8s-postgresql);
my @objects = map { YAML::XS::LoadFile("docker/k8s/$_") } @{ $kustomization->{resources} };
is join(' ', map { $_->{kind} } @objects), 'Deployment PodDisruptionBudget Service Deployment PodDisruptionBudget', 'Kubernetes gets these';
for my $object (grep { $_->{kind} eq 'Deployment' } @objects) {
    my $pod = $object->{spec}{template}{spec};
    my $daemon = $pod->{containers}[0];
    for my $literals (map { $_->{configMapGenerator}[0]{literals} } $kustomization, $without_s3) {
        holds($object->{metadata}{name}, map({ split /=/, $_, 2 } @$literals), map { $_->{name} => $_->{value} } @{ $daemon->{env} });
    }
    is scalar(grep { exists $_->{value} && !/_FILE|_KEYS/ && $_->{value} =~ m{//} } @{ $daemon->{env} }), 0, 'no secret stands there';
    ok $pod->{securityContext}{runAsNonRoot} && $daemon->{securityContext}{readOnlyRootFilesystem}, 'it is shut in';
    ok $daemon->{$_}{httpGet}{path} =~ m{^/(?:livez|readyz)$}, "and has a $_" for qw(startupProbe livenessProbe readinessProbe);
}
-x '/usr/bin/kubectl' and like qx(kubectl kustomize docker/$_ 2>&1), qr/^kind: Deployment\n/m, "kubectl takes $_" for qw(k8s k8s-postgresql);
done_testing();
