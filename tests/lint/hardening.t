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

# The compose file.
my $service = YAML::XS::LoadFile('docker/compose.yaml')->{services}{voronoid};
ok $service->{read_only}, 'the container\'s root is read-only';
is "@{ $service->{cap_drop} }", 'ALL', 'it has no capabilities';
ok !exists $service->{$_}, "nor $_" for qw(cap_add privileged devices network_mode pid);
is "@{ $service->{security_opt} }", 'no-new-privileges:true', 'and gains none';
like $service->{user}, qr/^[1-9]\d*:[1-9]\d*$/, 'it is not root';
cmp_ok $service->{pids_limit}, '<=', 1024, 'its processes are counted';
like $service->{mem_limit}, qr/^\d+g$/, 'and its memory';
is scalar(grep { !/^127\.0\.0\.1:/ } @{ $service->{ports} }), 0, 'its port is this machine\'s alone';
like slurp('docker/Dockerfile'), qr/^USER 65532:65532$/m, 'the image itself is not root\'s either';
done_testing();
